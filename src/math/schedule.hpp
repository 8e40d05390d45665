// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace splinevox {

/// Cosine from 1 at progress 0 to `end` at progress 1 and beyond. The end is decided by comparison: 1 +
/// cos(pi) of a rounded progress leaves a rate that is nearly, not exactly, the last one (numerics H24).
inline double cosine_decay(double progress, double end) {
  if (progress >= 1) return end;
  return end + (1 - end) * 0.5 * (1 + std::cos(std::numbers::pi * progress));
}

/// Where the schedules of a run by the clock stand, 0..1, after `seconds` of its `budget`; its first step
/// began at `start`, and what came before belongs to no schedule. Steps become dearer as lattices become
/// finer and batches larger: in even shares of the time most of them would be made on the first lattices. So
/// the schedule runs ahead of the clock, as if the cost of a step rose evenly with its progress p, from a to
/// 2 - a with (2 - a) / a = late_cost: the share of the time is a p + (1 - a) p^2 (docs/experiments.md). The
/// end is decided by comparison.
/// @param late_cost  >= 1; 1: even shares
inline double clock_progress(double seconds, double start, double budget, double late_cost) {
  if (seconds >= budget) return 1;
  if (seconds <= start) return 0;
  const double share = (seconds - start) / (budget - start), a = 2 / (1 + late_cost);
  return std::min(
      1.0,
      2 * share / (a + std::sqrt(a * a + 4 * (1 - a) * share)));  // the root in the form that does not cancel
}

}  // namespace splinevox
