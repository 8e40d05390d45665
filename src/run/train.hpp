// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/ranks.hpp"
#include "core/stopwatch.hpp"
#include "run/progress.hpp"
#include "run/watcher.hpp"
#include "splinevox/run/train.hpp"

namespace splinevox::run {

/// What became of a training run, for whoever tells it to a user.
struct TrainedRun {
  enum class End { finished, interrupted, was_finished };
  std::string folder;
  Json figures;  ///< of metrics.json, which is written; empty: interrupted before the first step, nothing is
  End end = End::finished;
  bool writes = true;  ///< false: another rank writes, and has the figures
};

/// Trains into a run folder. @param ranks  who trains with us; null: nobody. @param since_start  of the
/// budget.
/// @param watcher  who looks at it; null: nobody. Not with ranks
TrainedRun train(const TrainOptions& options, Ranks* ranks, Progress& progress, const Timer& since_start,
                 Watcher* watcher = nullptr);

}  // namespace splinevox::run
