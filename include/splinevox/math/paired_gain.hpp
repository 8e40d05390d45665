// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace splinevox {

/// What one treatment gains over another on the same units (here: held-out pictures), with what is known
/// about it.
struct PairedGain {
  double mean = 0;        ///< of the differences
  double lo = 0, hi = 0;  ///< one-sided bounds of the true mean, each at the level asked for
  double p = 1;           ///< chance of a mean at least this large if the true one is at most zero
  int count = 0;          ///< differences
};

/// Student's t on the differences. Fewer than two, or all equal, tell nothing of their spread: the bounds are
/// then infinite and p is 1 for fewer than two; for equal ones the bounds are the mean itself.
/// @param level  chance that a bound is on the wrong side, in (0, 0.5).
PairedGain paired_gain(std::span<const double> differences, double level);

}  // namespace splinevox
