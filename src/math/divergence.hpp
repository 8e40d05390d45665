// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Interpolated motion at a sample: value and spatial derivatives of the displacement before rigidity and of
/// raw rigidity.
template <class T>
struct MotionJet {
  Vec3T<T> delta;       ///< Delta_0, scene units
  Vec3T<T> d_delta[3];  ///< d_delta[j] = d Delta_0 / d x_j
  Vec3T<T> d_rho;       ///< gradient of raw rigidity, 1 / scene unit
  T r, r1, r2;          ///< sigmoid(rho) and its first and second derivative
};

/// Adjoint of a scalar function of a MotionJet: derivative with respect to each of its linear ingredients.
template <class T>
struct MotionJetAdjoint {
  Vec3T<T> delta;       ///< with respect to Delta_0
  T rho;                ///< with respect to raw rigidity
  Vec3T<T> d_delta[3];  ///< with respect to d Delta_0 / d x_j
  Vec3T<T> d_rho;       ///< with respect to grad rho
};

/// Exact divergence of Delta = r Delta_0: grad r . Delta_0 + r div Delta_0, and its adjoint.
/// Source: Spline-NeRF, Eq. 7; analytic because interpolation is trilinear, so no probe and no noise
/// (numerics H20).
template <class T>
SPLINEVOX_HD inline T divergence(const MotionJet<T>& m, MotionJetAdjoint<T>& d) {
  const T div0 = m.d_delta[0].x + m.d_delta[1].y + m.d_delta[2].z;
  const T along = dot(m.d_rho, m.delta);
  d.delta = m.r1 * m.d_rho;
  d.rho = m.r2 * along + m.r1 * div0;
  d.d_delta[0] = {m.r, 0, 0};
  d.d_delta[1] = {0, m.r, 0};
  d.d_delta[2] = {0, 0, m.r};
  d.d_rho = m.r1 * m.delta;
  return m.r1 * along + m.r * div0;
}

/// One Hutchinson probe e^T (grad Delta) e and its adjoint, the paper's and NR-NeRF's estimator. Its mean
/// over e is the divergence, but the mean of its square is larger: it also penalises shear.
template <class T>
SPLINEVOX_HD inline T divergence_probe(const MotionJet<T>& m, const Vec3T<T>& e, MotionJetAdjoint<T>& d) {
  const Vec3T<T> slope = e.x * m.d_delta[0] + e.y * m.d_delta[1] + e.z * m.d_delta[2];
  const T stretch = dot(e, slope), along = dot(m.delta, e), rho_e = dot(m.d_rho, e);
  d.delta = (m.r1 * rho_e) * e;
  d.rho = m.r2 * rho_e * along + m.r1 * stretch;
  for (int j = 0; j < 3; ++j) d.d_delta[j] = (m.r * e[j]) * e;
  d.d_rho = (m.r1 * along) * e;
  return m.r1 * rho_e * along + m.r * stretch;
}

}  // namespace splinevox
