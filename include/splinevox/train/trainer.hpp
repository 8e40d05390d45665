// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "splinevox/backend/device.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/cameras.hpp"
#include "splinevox/train/colour_loss.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox {

class Ranks;
class StepBackend;

/// Seconds spent so far in each part of a step, summed over steps (wall clock of the calling thread).
struct PhaseSeconds {
  double slices = 0, rays = 0, scatter = 0, regularise = 0, update = 0, occupancy = 0, refine = 0;
};

/// A ray whose loss or gradient was not finite: enough to find it again.
struct BadRay {
  int frame = 0;                         ///< of the training split
  std::int64_t index = 0;                ///< within the step's batch
  Vec3 origin{}, direction{}, target{};  ///< scene units, unit length, linear colour
  double time = 0;                       ///< of the model
};

/// What one training step reports.
struct StepReport {
  std::int64_t step = 0;               ///< steps done, this one included
  double progress = 0;                 ///< 0..1 of the budget
  double seconds = 0;                  ///< training seconds so far, resumed runs included
  double loss = 0;                     ///< of this batch: all terms that rays have
  double psnr = 0;                     ///< of this batch's rays
  std::int64_t rays = 0, samples = 0;  ///< of this step
  bool stage_changed = false;          ///< the lattices were refined, or bricks pruned, before this step
  bool discarded = false;              ///< something was not finite, so no parameter was touched
  std::int64_t bad_rows = 0;           ///< of a discarded step: rows whose gradient is not finite
  std::vector<BadRay> bad_rays;  ///< of a discarded step: the rays that caused it, kBadRaysKept at most;
                                 ///< none: a regulariser did
};

/// Trains a model. One step is refine, draw, slice, forward and backward, scatter, regularise, update. Runs
/// on the TBB threads of the calling arena, or on a device, and on the CPU gives the same bits for any number
/// of threads, provided max_steps (not max_time) lays out the schedule.
class Trainer {
 public:
  /// `train` must outlive the trainer. `seconds_used`: seconds of the budget spent before training (loading
  /// data). `ranks`: processes to train with (core/ranks.hpp), each with a trainer of the same config and
  /// data; outlives the trainer. `device`: where steps are made (choose_device); batches are drawn and
  /// lattices changed on the threads either way. `deterministic`: the same bits in every run on a device too.
  /// Throws Error (input) where the device cannot train with these ranks.
  Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used = 0,
          Ranks* ranks = nullptr, Device device = Device::cpu, bool deterministic = false);
  /// The same with whoever makes the steps (backend/step.hpp), made for these ranks; not null.
  Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used,
          Ranks* ranks, std::unique_ptr<StepBackend> backend);
  ~Trainer();

  static constexpr int kMostDiscarded = 5, kBadRaysKept = 32;
  static constexpr std::uint32_t kStateFormat = 10;  ///< of what save() gives

  /// From the next step on `loss` takes the place of the photometric loss; empty: that comes back. All else
  /// stays: losses of motion and depth, total variation, and what is learned of errors (where rays are drawn,
  /// gains of cameras). Colours are rendered once more for it. The same bits in every run if the loss has.
  /// Called by the thread that calls step(), which throws what it throws and then is as before that step.
  /// save() does not keep it. Throws Error (input) where a device or several processes make the steps.
  void set_loss(ColourLoss loss);

  bool done() const;
  /// One step. One whose loss or gradient is not finite changes no parameter and says so in its report; the
  /// next one draws other rays. After kMostDiscarded of them in a row the step counter goes back to the last
  /// good step and Error (Fault::numeric) is thrown. `seconds_outside`: of the budget, that went by between
  /// the last step and this one (pictures to look at, copies of the state).
  StepReport step(double seconds_outside = 0);
  /// Adds seconds to the budget of a run that goes by the clock. Schedules are laid out anew over it, as
  /// where such a run is resumed with more time. @pre RunConfig::max_time > 0
  void add_time(double seconds);
  /// The settings that steps are made with: those of the call, fitted to the pictures, their cameras and
  /// their brightness.
  const Config& settings() const;
  /// Reports of the last steps, as far as they were discarded in a row.
  const std::vector<StepReport>& discarded() const;

  /// The model as it is: motion levels collapsed into one, ready for render_image and for model.vdb.
  VoxelModel model() const;
  /// The same at the end of training, whose memory it frees: no step, model(), save() or restore() after it.
  VoxelModel finish();
  /// What is known of the cameras by now; [Dataset::cameras] up to the last with training pictures. Empty:
  /// they are no rig, or nothing is learned of them.
  const CameraFits& cameras() const;
  PhaseSeconds phases() const;
  /// Share of what is visible that was moving when the static regions were frozen (MotionConfig::rest); 1:
  /// motion is learned everywhere.
  double moving_share() const;
  /// Seconds of the budget spent so far, loading and earlier sessions included.
  double seconds() const;

  /// Everything an exact resume needs, as bytes. `restore` takes what `save` of a trainer with the same
  /// config and data gave; throws Error if it does not fit.
  std::vector<char> save() const;
  /// The same bytes in pieces, most of them where training has them: for whoever writes them somewhere,
  /// before `take` returns.
  void save(const std::function<void(std::span<const std::string_view>)>& take) const;
  void restore(const std::vector<char>& bytes);

 private:
  struct State;
  StepReport one_step();
  std::unique_ptr<State> state_;
};

}  // namespace splinevox
