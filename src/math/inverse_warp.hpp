// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/velocity.hpp"

namespace splinevox {

/// Where a canonical place is at a time, as far as the warp can be inverted there.
template <class T>
struct InverseWarp {
  Vec3T<T> x;      ///< x + Delta(x) = target up to `residual`
  T residual;      ///< |x + Delta(x) - target|, scene units
  bool converged;  ///< residual <= tolerance
  bool folded;     ///< the warp turns inside out or is squashed at x (math/velocity.hpp)
};

/// Solves x + Delta(x) = target by Newton steps from `start`, damped where the warp folds (the step is that
/// of material_velocity with the residual for dDelta/dt) and halved until the residual falls. The warp need
/// not have an inverse: the result is then the place of the smallest residual met, not converged.
/// @param warp  x -> {displacement, gradient[3]} as FrameSampler::Warp; trilinear, so its gradient jumps at
/// cell faces, and
///              plain Newton can walk in circles across one: hence the halving.
template <class T, class Warp>
InverseWarp<T> invert_warp(Warp&& warp, const Vec3T<T>& target, const Vec3T<T>& start, T tolerance) {
  constexpr int kSteps = 24, kHalvings = 8;
  struct Place {
    Vec3T<T> x, error, gradient[3];
    T residual;
  };
  const auto visit = [&](const Vec3T<T>& x) {
    const auto w = warp(x);
    Place p{x,
            x + cast<T>(w.displacement) - target,
            {cast<T>(w.gradient[0]), cast<T>(w.gradient[1]), cast<T>(w.gradient[2])},
            T(0)};
    p.residual = length(p.error);
    return p;
  };
  Place best = visit(start);
  for (int i = 0; i < kSteps && best.residual > tolerance; ++i) {
    const Vec3T<T> step = material_velocity(best.gradient, best.error).velocity;
    T share = 1;
    Place next = visit(best.x + step);
    for (int h = 0; h < kHalvings && !(next.residual < best.residual); ++h)
      next = visit(best.x + (share *= T(0.5)) * step);
    if (!(next.residual < best.residual)) break;
    best = next;
  }
  return {best.x, best.residual, best.residual <= tolerance,
          material_velocity(best.gradient, best.error).folded};
}

}  // namespace splinevox
