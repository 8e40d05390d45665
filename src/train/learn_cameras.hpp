// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/step.hpp"
#include "splinevox/train/cameras.hpp"
#include "splinevox/train/config.hpp"
#include "train/archive.hpp"
#include "train/batch.hpp"
#include "train/volume.hpp"

namespace splinevox {

/// The cameras of a rig: those that took three moments or more of a split, if there are two or more of them;
/// else none. Of a frame of another camera nothing is learned.
CameraFits rig_of(const Split& train);

/// Learns the gain and the clock of every camera of a rig, beside the model and with its rays.
///
/// Gains: least squares over the rays of some hundred steps (math/exposure.hpp), so that no rate has to suit
/// every scene. Their geometric mean over the cameras is 1 in every channel: the model has the mean exposure.
/// A gain that has come to the end of its range counts in no mean, or a covered lens would brighten all else.
///
/// Clocks: one number a camera, by d loss / d time of the slices that its frames read. Steps are Adam's but
/// for the second moment, which is that of all cameras together: a camera that tells little of its time would
/// go as far as one that tells much. The median over the cameras is 0: those that agree are right, and the
/// model has their time.
class CameraLearner {
 public:
  CameraLearner() = default;
  /// @param unit  of brightness
  CameraLearner(const CamerasConfig& config, const CameraFits& fits, float unit);

  bool gains() const { return config_.exposure && !learned_.empty(); }
  bool clocks() const { return config_.clock && !learned_.empty(); }

  /// One step on what the configuration wants. @param rate  of the clocks, times their own
  void update(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
              const MomentFactors& factors, double progress, double rate);

  /// Whether a clock has gone on so far since `look` that frames look for matter at another moment.
  bool strayed(const CameraFits& fits) const;
  void look(const CameraFits& fits);

  void archive(Archive& a, CameraFits& fits);

 private:
  struct Learned {
    Vec3d along{}, square{};  ///< of GainTerm, older steps fading
    double m = 0;             ///< first moment of the clock's gradient, per interval
    double looked = 0;        ///< offset at the last look
  };
  void update_gains(CameraFits& fits, const Batch& batch, const StepSums& sums);
  void update_clocks(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
                     const MomentFactors& factors, double rate);

  CamerasConfig config_;
  float unit_ = 1;
  std::vector<Learned> learned_;  ///< [cameras]
  double square_ = 0;             ///< second moment of the clocks' gradients, of all together
};

}  // namespace splinevox
