// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/pack.hpp"
#include "core/rng.hpp"
#include "math/divergence.hpp"
#include "math/offset.hpp"

namespace splinevox {

/// Weights of the per-sample motion losses (Eq. 6 and 7), already multiplied by their ramp.
template <class Real>
struct MotionLoss {
  Real offset = 0, offset_rigidity = 0, offset_softening = 1e-4;  ///< softening in scene units
  Real divergence = 0;
  bool hutchinson = false;
};

/// A Rademacher probe for a ray: each component +1 or -1.
SPLINEVOX_HD inline Vec3 draw_probe(std::uint64_t seed, std::size_t ray) {
  const std::uint64_t bits = Rng(seed, 5).bits(ray);
  return {bits & 1 ? 1.0f : -1.0f, bits & 2 ? 1.0f : -1.0f, bits & 4 ? 1.0f : -1.0f};
}

/// The inputs of the motion losses, from the slice as it was interpolated.
/// @param v    Delta_0 and raw rigidity, and their derivatives along the fractions of a cell.   @param inv  1
/// / spacing of the motion lattice.
/// @param r    sigmoid of raw rigidity.   @param r1  its derivative.
template <class Real, class Interpolated>
SPLINEVOX_INLINE MotionJet<Real> motion_jet(const Interpolated& v, Real inv, Real r, Real r1) {
  MotionJet<Real> jet;
  jet.delta = {v.value[0], v.value[1], v.value[2]};
  const decltype(v.dx)* const slope[3] = {&v.dx, &v.dy, &v.dz};
  SPLINEVOX_UNROLL for (int j = 0; j < 3; ++j) {
    jet.d_delta[j] = inv * Vec3T<Real>{(*slope[j])[0], (*slope[j])[1], (*slope[j])[2]};
    jet.d_rho[j] = inv * (*slope[j])[3];
  }
  jet.r = r;
  jet.r1 = r1;
  jet.r2 = r1 * (1 - 2 * r);
  return jet;
}

/// Offset and divergence losses of one sample: returns their value and adds their gradients. Visibility
/// weights are constants here, as in the paper.
/// @param w    share of the sample in its pixel.   @param inv  1 / spacing of the motion lattice.
/// @param g    [4] by what was interpolated: Delta_0 and raw rigidity.   @param h  [3][4] by its derivatives
/// along the fractions.
template <class Real, class Values, class Slopes>
SPLINEVOX_INLINE Real motion_loss_sample(const MotionJet<Real>& jet, const MotionLoss<Real>& loss,
                                         const Vec3T<Real>& probe, Real w, Real inv, Values& g, Slopes& h) {
  Real value = 0;
  if (loss.offset > 0) {
    const auto term = offset_term(jet.delta, jet.r, loss.offset_rigidity, loss.offset_softening);
    const Real scale = loss.offset * w;
    value += scale * term.value;
    for (int a = 0; a < 3; ++a) g[a] += scale * term.d_delta[a];
    g[3] += scale * term.d_r * jet.r1;
  }
  if (loss.divergence > 0) {
    MotionJetAdjoint<Real> d;
    const Real q = loss.hutchinson ? divergence_probe(jet, probe, d) : divergence(jet, d);
    value += loss.divergence * w * q * q;
    const Real scale = 2 * loss.divergence * w * q;
    for (int a = 0; a < 3; ++a) g[a] += scale * d.delta[a];
    g[3] += scale * d.rho;
    for (int j = 0; j < 3; ++j) {
      for (int a = 0; a < 3; ++a) h[j][a] += scale * inv * d.d_delta[j][a];
      h[j][3] += scale * inv * d.d_rho[j];
    }
  }
  return value;
}

}  // namespace splinevox
