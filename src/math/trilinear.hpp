// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/hd.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Corner c of a cell is (x, y, z) = (c >> 2 & 1, c >> 1 & 1, c & 1): z fastest, like the rows of a brick.
inline constexpr int kCorners = 8;
SPLINEVOX_HD constexpr Int3 corner(int c) { return {c >> 2 & 1, c >> 1 & 1, c & 1}; }

/// The eight trilinear weights at fractions f in [0, 1]; they sum to 1 within 4 units of rounding.
template <class T>
SPLINEVOX_INLINE constexpr void trilinear_weights(const Vec3T<T>& f, T (&w)[kCorners]) {
  const T gx = T(1) - f.x, gy = T(1) - f.y, gz = T(1) - f.z;
  const T w00 = gx * gy, w01 = gx * f.y, w10 = f.x * gy, w11 = f.x * f.y;
  w[0] = w00 * gz;
  w[1] = w00 * f.z;
  w[2] = w01 * gz;
  w[3] = w01 * f.z;
  w[4] = w10 * gz;
  w[5] = w10 * f.z;
  w[6] = w11 * gz;
  w[7] = w11 * f.z;
}

/// d weight / d fraction per corner; divide by the lattice spacing for d / d position.
template <class T>
SPLINEVOX_HD constexpr void trilinear_weight_gradients(const Vec3T<T>& f, Vec3T<T> (&d)[kCorners]) {
  for (int c = 0; c < kCorners; ++c) {
    const T sx = c & 4 ? T(1) : T(-1), sy = c & 2 ? T(1) : T(-1), sz = c & 1 ? T(1) : T(-1);
    const T wx = c & 4 ? f.x : T(1) - f.x, wy = c & 2 ? f.y : T(1) - f.y, wz = c & 1 ? f.z : T(1) - f.z;
    d[c] = {sx * wy * wz, wx * sy * wz, wx * wy * sz};
  }
}

/// Value and its derivatives with respect to the three fractions, from the eight corner values. V is anything
/// with
/// +, - and multiplication by T: a float, a register of eight channels, a dual number.
template <class V>
struct TrilinearValue {
  V value, dx, dy, dz;
};

template <class T, class V>
SPLINEVOX_INLINE TrilinearValue<V> trilinear_with_gradient(const Vec3T<T>& f, const V& c0, const V& c1,
                                                           const V& c2, const V& c3, const V& c4, const V& c5,
                                                           const V& c6, const V& c7) {
  // Along x first: four edges, their values and slopes; then y, then z.
  const V d0 = c4 - c0, d1 = c5 - c1, d2 = c6 - c2, d3 = c7 - c3;
  const V a0 = c0 + d0 * f.x, a1 = c1 + d1 * f.x, a2 = c2 + d2 * f.x, a3 = c3 + d3 * f.x;
  const V e0 = a2 - a0, e1 = a3 - a1;
  const V b0 = a0 + e0 * f.y, b1 = a1 + e1 * f.y;
  const V x0 = d0 + (d2 - d0) * f.y, x1 = d1 + (d3 - d1) * f.y;
  const V dz = b1 - b0;
  return {b0 + dz * f.z, x0 + (x1 - x0) * f.z, e0 + (e1 - e0) * f.z, dz};
}

}  // namespace splinevox
