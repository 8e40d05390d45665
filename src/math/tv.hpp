// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/hd.hpp"

namespace splinevox {

/// Total variation at one voxel and its derivatives with respect to the voxel and its +x, +y, +z neighbours.
template <class V>
struct TvTerm {
  V value, d_self, d_x, d_y, d_z;
};

/// eps of the optimiser: differences of stored values below 1e-5 are no edges.
inline constexpr float kTvSoftening = 1e-10f;

/// Isotropic total variation of one component at one voxel:  sqrt(dx^2 + dy^2 + dz^2 + eps) - sqrt(eps), d* =
/// v - v*.
///
/// Source: Spline-NeRF, Eq. 9, without the mean over voxels. One eps in value and derivatives, so the
/// gradient is the gradient of what is reported (numerics H18). A missing neighbour is passed as v itself:
/// that axis does not count.
/// @tparam V     a scalar or a register of components.
/// @param eps    > 0, unit of v squared.
/// @param root   square root on V.
template <class V, class T, class Sqrt>
SPLINEVOX_HD inline TvTerm<V> tv_term(const V& v, const V& vx, const V& vy, const V& vz, T eps, Sqrt root) {
  const V dx = v - vx, dy = v - vy, dz = v - vz;
  const V squares = dx * dx + dy * dy + dz * dz;
  const V length = root(squares + eps);
  const V inv = T(1) / length;
  const V gx = dx * inv, gy = dy * inv, gz = dz * inv;
  // sqrt(s + eps) - sqrt(eps) as printed cancels where s << eps: in float it is 0 for |d| < 3e-9 at eps =
  // 1e-10.
  return {squares / (length + std::sqrt(eps)), gx + gy + gz, -gx, -gy, -gz};
}

}  // namespace splinevox
