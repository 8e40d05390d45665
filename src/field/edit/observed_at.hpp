// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <limits>

#include "math/inverse_warp.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {

/// The y that shows a canonical place at a time, W(y) = target: what one of the starts leads to, the first
/// that does; else the one that comes nearest.
inline Vec3d observed_at(const FrameSampler& at_time, const Vec3d& target,
                         std::initializer_list<Vec3d> starts, double tolerance) {
  InverseWarp<double> best{{}, std::numeric_limits<double>::infinity(), false, true};
  for (const Vec3d& start : starts) {
    const auto found =
        invert_warp([&](const Vec3d& x) { return at_time.warp(cast<float>(x)); }, target, start, tolerance);
    if (found.residual < best.residual) best = found;
    if (best.converged && !best.folded) break;
  }
  return best.x;
}

}  // namespace splinevox
