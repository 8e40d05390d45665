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

/// Whether the pictures are of one camera on its way: each has its time and its place, and neighbours in time
/// are near each other.
bool in_sequence(const Split& train);

/// Cameras anywhere, one in_sequence, those of a rig_of: what can be learned of one can be of the next.
enum class TakenBy { any, film, rig };
TakenBy taken_by(const Split& train);

/// The cameras that `config` wants to learn something of: those of a rig, or, if exposures drift, the one of
/// a film. If they drift, with as many gains of each as there are pictures for, alike for all.
CameraFits cameras_to_learn(const CamerasConfig& config, const Split& train);

/// Learns the gain and the clock of every camera, beside the model and with its rays.
///
/// Gains: least squares over the rays of some hundred steps (math/exposure.hpp), so that no rate has to suit
/// every scene. Where they drift, a ray has a share in the two gains that its time lies between, by how near
/// it is to each. Their geometric mean over the cameras is 1 in every channel, at each of their times: the
/// model has the mean exposure, and what all cameras see change is the scene's. That of a film is 1 over its
/// times. A gain that has come to the end of its range counts in no mean, or a covered lens would brighten
/// all else.
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

  bool gains() const { return (config_.exposure || config_.drift) && !learned_.empty(); }
  bool clocks() const { return config_.clock && !learned_.empty(); }

  /// One step on what the configuration wants. @param rate  of the clocks, times their own
  void update(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
              const MomentFactors& factors, double progress, double rate);

  /// Whether a clock has gone on so far since `look` that frames look for matter at another moment.
  bool strayed(const CameraFits& fits) const;
  void look(const CameraFits& fits);

  void archive(Archive& a, CameraFits& fits);

 private:
  /// A row of the normal equations, for one gain: of GainTerm, each ray times its share in this gain, the
  /// squares also times its share in the one before, this and the next. Older steps fade.
  struct Row {
    Vec3d along{}, before{}, square{}, next{};
  };
  struct Learned {
    std::vector<Row> rows;  ///< of each gain
    double m = 0;           ///< first moment of the clock's gradient, per interval
    double looked = 0;      ///< offset at the last look
  };
  /// Into the rows of the normal equations.
  void add_rays(const CameraFits& fits, const Batch& batch, const StepSums& sums);
  static std::vector<double> logs_of(const std::vector<Row>& rows, int channel, double most);
  void update_gains(CameraFits& fits, const Batch& batch, const StepSums& sums);
  void update_clocks(CameraFits& fits, const Split& train, const Batch& batch, const StepSums& sums,
                     const MomentFactors& factors, double rate);

  CamerasConfig config_;
  float unit_ = 1;
  std::vector<Learned> learned_;  ///< [cameras]
  double square_ = 0;             ///< second moment of the clocks' gradients, of all together
};

}  // namespace splinevox
