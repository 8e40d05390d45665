// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// w, x, y, z. Of length 1 it is a rotation, and its negative is the same one.
using Quaternion = std::array<double, 4>;

/// The rotation that takes the axes of the world to these (Shepperd 1978: the largest of four is divided by).
/// @param axes  orthonormal, right-handed
inline Quaternion quaternion_of(const std::array<Vec3d, 3>& axes) {
  const double xx = axes[0].x, yy = axes[1].y, zz = axes[2].z;
  const double yz = axes[1].z - axes[2].y, zx = axes[2].x - axes[0].z, xy = axes[0].y - axes[1].x;
  const double sum_xy = axes[0].y + axes[1].x, sum_yz = axes[1].z + axes[2].y, sum_zx = axes[2].x + axes[0].z;
  const std::array<Quaternion, 4> rows{
      Quaternion{1 + xx + yy + zz, yz, zx, xy}, Quaternion{yz, 1 + xx - yy - zz, sum_xy, sum_zx},
      Quaternion{zx, sum_xy, 1 - xx + yy - zz, sum_yz}, Quaternion{xy, sum_zx, sum_yz, 1 - xx - yy + zz}};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (rows[i][i] > rows[largest][largest]) largest = i;
  Quaternion q = rows[largest];
  const double scale = 1 / (2 * std::sqrt(q[largest]));
  for (double& v : q) v *= scale;
  return q;
}

/// Its axes: the inverse of quaternion_of. @param q  of any length above 0
inline std::array<Vec3d, 3> axes_of(const Quaternion& q) {
  const double s = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return {Vec3d{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
          Vec3d{s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)},
          Vec3d{s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)}};
}

}  // namespace splinevox
