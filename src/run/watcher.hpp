// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "run/support.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::run {

/// What a training is made of, for who looks at it. All of it outlives the training, and no more.
struct Watched {
  const Config& config;
  const Dataset& data;
  const Frame& held_out;     ///< the view that previews show
  bool of_training = false;  ///< that is a view of the training split
  std::string folder;        ///< of the run
};

/// What who looks asks for.
struct Wishes {
  bool stop = false;     ///< save and end, as after a signal
  bool pause = false;    ///< make no step
  double more_time = 0;  ///< seconds to add to the budget; told once
};

/// Who looks at a training while it runs, and may act on it: the page of `train --live`. All calls come from
/// the thread that trains, between two steps.
class Watcher {
 public:
  virtual ~Watcher() = default;
  /// Whether an end is wished for, also before the first step.
  virtual bool stop_wished() const = 0;
  /// Once, before the first step.
  virtual void begin(const Watched& training) = 0;
  /// A line that metrics.jsonl gets, JSON. @param left  seconds that the rest takes, if that can be told
  virtual void line(const std::string& line, std::optional<double> left) = 0;
  /// Whether the model should be handed over now: somebody asks for it, and it may cost as much again.
  /// @param step  that it has come to
  virtual bool wants_model(std::int64_t step) const = 0;
  /// @param cost  seconds of a processor that the copy took
  virtual void model(VoxelModel model, std::int64_t step, double cost) = 0;
  virtual Wishes take_wishes() = 0;
  /// Waits until something is wished for, or a tenth of a second.
  virtual void wait() = 0;
  /// The last step is made: from here on wishes are refused. @param anyway  though more time is wished for
  /// @return false: it is, so there is more to do
  virtual bool close(bool anyway) = 0;
  /// The training has ended. @param model  as it is saved
  virtual void end(const VoxelModel& model, std::int64_t step, bool finished) = 0;
};

}  // namespace splinevox::run
