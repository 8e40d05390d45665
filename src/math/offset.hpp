// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

template <class T>
struct OffsetTerm {
  T value;           ///< scene units^(2 - r), plus lambda_r r
  Vec3T<T> d_delta;  ///< d value / d Delta_0
  T d_r;             ///< d value / d r
};

/// Offset loss of one sample, |Delta_0|^(2 - r) + lambda_r r, with the length softened: s = |Delta_0|^2 +
/// e^2, value = s^(1 - r/2) - e^(2 - r) + lambda_r r.
///
/// Source: Spline-NeRF, Eq. 6. The plain form has NaN gradients at Delta_0 = 0 in both arguments (0 log 0);
/// with e > 0 both are finite and exact derivatives of what is returned (numerics H17).
/// @param r  rigidity in [0, 1]; 1 moves, 0 is static.   @param e  > 0, scene units.
template <class T>
SPLINEVOX_HD inline OffsetTerm<T> offset_term(const Vec3T<T>& delta, T r, T lambda_r, T e) {
  using std::log;
  using std::pow;
  const T s = dot(delta, delta) + e * e;
  const T power = pow(s, T(1) - T(0.5) * r), floor = pow(e, T(2) - r);
  return {power - floor + lambda_r * r, ((T(2) - r) * power / s) * delta,
          floor * log(e) - T(0.5) * log(s) * power + lambda_r};
}

}  // namespace splinevox
