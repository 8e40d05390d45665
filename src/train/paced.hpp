// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "splinevox/train/config.hpp"

namespace splinevox {

/// Whether seconds alone end a run.
inline bool by_clock(const RunConfig& run) { return run.max_time > 0 && run.max_steps == 0; }

/// What a run leaves out where its seconds pay for few batches (RunClock::batches): a slow machine, or opaque
/// pictures, whose rays have many samples (docs/experiments/time.md, "What should a run do that has time
/// for few steps?").
/// @{
/// Rays of a step, as a share of the configuration's: more steps of fewer rays.
inline double batch_share(double batches) {
  constexpr double kEnough = 400, kLeast = 0.25;
  return std::clamp(batches / kEnough, kLeast, 1.0);
}
/// Stages of GridConfig::radiance: finer cells than so many batches can fill only cost time.
inline int most_stages(double batches) {
  constexpr double kOfStage = 130, kMost = 100;
  constexpr int kFewest = 2;
  return std::max(kFewest, int(std::min(batches / kOfStage, kMost)));
}
/// @}

}  // namespace splinevox
