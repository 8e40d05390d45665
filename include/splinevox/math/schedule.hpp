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

}  // namespace splinevox
