// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

inline constexpr double kSh0 = 0.28209479177387814;  ///< Y_0, the same in every direction: 1 / sqrt(4 pi)

/// Real spherical harmonics of a unit direction, bands 0..order, orthonormal over the sphere.
/// Y[l (l + 1) + m] for m = -l..l.
/// @pre |d| = 1: with a length of 1.1 band 2 is off by 21% (numerics H27); rays are normalised where they are
/// made.
template <class T>
SPLINEVOX_HD inline void sh_basis(int order, const Vec3T<T>& d, T* y) {
  y[0] = T(kSh0);
  if (order < 1) return;
  const T a = T(0.4886025119029199);
  y[1] = a * d.y;
  y[2] = a * d.z;
  y[3] = a * d.x;
  if (order < 2) return;
  const T xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z, b = T(1.0925484305920792);
  y[4] = b * d.x * d.y;
  y[5] = b * d.y * d.z;
  y[6] = T(0.31539156525252005) * (T(3) * zz - T(1));
  y[7] = b * d.x * d.z;
  y[8] = T(0.5462742152960396) * (xx - yy);
  if (order < 3) return;
  y[9] = T(0.5900435899266435) * d.y * (T(3) * xx - yy);
  y[10] = T(2.890611442640554) * d.x * d.y * d.z;
  y[11] = T(0.4570457994644658) * d.y * (T(5) * zz - T(1));
  y[12] = T(0.3731763325901154) * d.z * (T(5) * zz - T(3));
  y[13] = T(0.4570457994644658) * d.x * (T(5) * zz - T(1));
  y[14] = T(1.445305721320277) * d.z * (xx - yy);
  y[15] = T(0.5900435899266435) * d.x * (xx - T(3) * yy);
}

}  // namespace splinevox
