// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace splinevox {

/// Cosine from 1 at progress 0 to `end` at progress 1 and beyond. The end is decided by comparison: 1 + cos(pi) of a
/// rounded progress leaves a rate that is nearly, not exactly, the last one (numerics H24).
inline double cosine_decay(double progress, double end) {
  if (progress >= 1) return end;
  return end + (1 - end) * 0.5 * (1 + std::cos(std::numbers::pi * progress));
}

/// Where the schedules of a run by the clock stand, 0..1, after `seconds` of its `budget`; its first step began at `start`, and what came before belongs
/// to no schedule. Steps become dearer as lattices become finer and batches larger: in even shares of the time most of them would be
/// made on the first lattices. A pace below 1 lets the schedule run ahead of the clock (docs/experiments.md). The end is decided by comparison.
/// @pre 0 < pace
inline double clock_progress(double seconds, double start, double budget, double pace) {
  if (seconds >= budget) return 1;
  if (seconds <= start) return 0;
  return std::pow((seconds - start) / (budget - start), pace);
}

}  // namespace splinevox
