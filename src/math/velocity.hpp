// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Smallest eigenvalue of the symmetric 3x3 matrix with diagonal d and off-diagonal entries o = (m12, m02,
/// m01), by the trigonometric solution of the characteristic polynomial. Absolute error about one rounding of
/// the largest eigenvalue.
template <class T>
SPLINEVOX_HD T smallest_eigenvalue(const Vec3T<T>& d, const Vec3T<T>& o) {
  using std::acos, std::cos, std::sqrt;
  const T mean = (d.x + d.y + d.z) / T(3);
  const Vec3T<T> c = d - Vec3T<T>{mean, mean, mean};
  const T spread = sqrt((dot(c, c) + T(2) * dot(o, o)) / T(6));
  if (!(spread > T(0))) return mean;
  const T det = c.x * (c.y * c.z - o.x * o.x) - o.z * (o.z * c.z - o.x * o.y) + o.y * (o.z * o.x - c.y * o.y);
  T r = det / (T(2) * spread * spread * spread);
  r = r < T(-1) ? T(-1) : r > T(1) ? T(1) : r;
  constexpr double kThirdTurn = 2.09439510239319549;
  return mean + T(2) * spread * cos(acos(r) / T(3) + T(kThirdTurn));
}

/// What moves at x, and whether the warp can be trusted there.
template <class T>
struct MaterialVelocity {
  Vec3T<T> velocity;  ///< scene units per unit of time
  T stretch;          ///< smallest singular value of I + grad Delta: 1 where the motion is rigid
  bool folded;        ///< det(I + grad Delta) <= 0 or stretch < 0.05: the velocity is damped, not exact
};

inline constexpr double kFoldStretch = 0.05;

/// Velocity of the material at x from the backward warp x' = x + Delta(x, t).
///
/// Delta bends rays: it says where in the canonical volume to look. A particle keeps its canonical place, so
/// along its path
///   d/dt (x + Delta(x, t)) = 0  =>  v + grad Delta v + dDelta/dt = 0  =>  v = -(I + grad Delta)^-1
///   dDelta/dt,
/// which is not dDelta/dt. Near a fold the inverse has no meaning; there the damped least-squares solution is
/// taken,
///   v = -(A^T A + mu^2 I)^-1 A^T b,  A = I + grad Delta,  b = dDelta/dt,  mu = max(0, 0.05 - smallest
///   singular value of A),
/// which is exact for mu = 0 and bounded by |v| <= 25 |b| everywhere (numerics H21).
///
/// @param gradient  gradient[i][j] = d Delta_i / d x_j, unitless, finite.
/// @param d_dt      dDelta/dt, scene units per unit of time, finite.
/// @tparam T        double in production: float loses all digits at a stretch of 1e-5.
template <class T>
SPLINEVOX_HD MaterialVelocity<T> material_velocity(const Vec3T<T> (&gradient)[3], const Vec3T<T>& d_dt) {
  using std::sqrt;
  Vec3T<T> row[3] = {gradient[0], gradient[1], gradient[2]};
  for (int i = 0; i < 3; ++i) row[i][i] = row[i][i] + T(1);
  const T det = dot(row[0], cross(row[1], row[2]));

  const auto column = [&](int j) { return Vec3T<T>{row[0][j], row[1][j], row[2][j]}; };
  const Vec3T<T> c0 = column(0), c1 = column(1), c2 = column(2);
  Vec3T<T> d{dot(c0, c0), dot(c1, c1), dot(c2, c2)};  // A^T A
  const Vec3T<T> o{dot(c1, c2), dot(c0, c2), dot(c0, c1)};
  const T least = smallest_eigenvalue(d, o);
  const T stretch = least > T(0) ? sqrt(least) : T(0);
  const T mu = stretch < T(kFoldStretch) ? T(kFoldStretch) - stretch : T(0);
  d = d + Vec3T<T>{mu * mu, mu * mu, mu * mu};

  // Symmetric positive definite: Cramer's rule with the adjugate.
  const Vec3T<T> r0{d.x, o.z, o.y}, r1{o.z, d.y, o.x}, r2{o.y, o.x, d.z};
  const Vec3T<T> a0 = cross(r1, r2), a1 = cross(r2, r0), a2 = cross(r0, r1);
  const Vec3T<T> right{dot(c0, d_dt), dot(c1, d_dt), dot(c2, d_dt)};
  const Vec3T<T> solution = (right.x * a0 + right.y * a1 + right.z * a2) * (T(-1) / dot(r0, a0));
  return {solution, stretch, det <= T(0) || stretch < T(kFoldStretch)};
}

}  // namespace splinevox
