// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/light.hpp"
#include "math/rigidity.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A contracted row of the motion lattice, interpolated, says how the place of a sample is warped (Eq. 4):
/// Delta = r Delta_0 with Delta_0 in its columns 0 to 2, r = rigidity_of(column 3), and its light is
/// light_gain(column 4).
///
/// @param motion  columns 0 to 3 or more: anything with an index.
template <class T, class Motion>
SPLINEVOX_INLINE Vec3T<T> displacement_of(const Motion& motion, T rigidity) {
  return {rigidity * motion[0], rigidity * motion[1], rigidity * motion[2]};
}

/// Its adjoint: columns 0 to 3 of the row's gradient.
/// @param d_delta  d loss / d Delta
template <class T, class Motion, class Row>
SPLINEVOX_INLINE void displacement_vjp(const Vec3T<T>& d_delta, const Motion& motion, T rigidity,
                                       T rigidity_slope, Row& gradient) {
  SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) gradient[a] = rigidity * d_delta[a];
  gradient[3] = rigidity_slope * (d_delta.x * motion[0] + d_delta.y * motion[1] + d_delta.z * motion[2]);
}

/// Prior on samples: weight * share * |Delta|^2. Its gradient by Delta; the share in the pixel is a constant,
/// as in Eq. 6. @param weight  1 / scene unit^2
template <class T>
SPLINEVOX_INLINE Vec3T<T> rest_vjp(T weight, T share, const Vec3T<T>& displacement) {
  return (2 * weight * share) * displacement;
}

}  // namespace splinevox
