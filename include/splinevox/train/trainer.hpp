// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox {

/// Seconds spent so far in each part of a step, summed over steps (wall clock of the calling thread).
struct PhaseSeconds {
  double slices = 0, rays = 0, scatter = 0, regularise = 0, update = 0, occupancy = 0, refine = 0;
};

/// What one training step reports.
struct StepReport {
  std::int64_t step = 0;     ///< steps done, this one included
  double progress = 0;       ///< 0..1 of the budget
  double seconds = 0;        ///< training seconds so far, resumed runs included
  double loss = 0;           ///< photometric loss of this batch
  double psnr = 0;           ///< of this batch's rays
  std::int64_t rays = 0, samples = 0;  ///< of this step
  bool stage_changed = false;          ///< the lattices were refined before this step
  bool discarded = false;              ///< loss or gradient was not finite: nothing was changed, loss and psnr are NaN
};

/// Trains a model. One step is draw, forward, loss, backward, regularise, update. Runs on the TBB threads of the calling
/// arena and gives the same bits for any number of them, provided max_steps (not max_time) lays out the schedule.
class Trainer {
 public:
  /// `train` must outlive the trainer. `seconds_used`: seconds of the budget spent before training (loading data).
  Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used = 0);
  ~Trainer();

  bool done() const;
  /// A step whose loss or gradient is not finite leaves every parameter and moment as it is; after five of them in a row
  /// throws Error (Fault::numeric).
  StepReport step();

  /// The model as it is: motion levels collapsed into one, ready for render_image and for model.vdb.
  VoxelModel model() const;
  PhaseSeconds phases() const;
  /// Seconds of the budget spent so far, loading and earlier sessions included.
  double seconds() const;

  /// Everything an exact resume needs, as bytes. `restore` takes what `save` of a trainer with the same config and data
  /// gave; throws Error if it does not fit.
  std::vector<char> save() const;
  void restore(const std::vector<char>& bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace splinevox
