// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/track_loss.hpp"
#include "render/ray_kernel.hpp"
#include "render/records.hpp"

namespace splinevox {

/// Where the ray that a kernel just marched sees its point. One that met next to nothing sees none.
template <class Real, int Sh>
Sighting<Real> sighting_of(const RayKernel<Real, Sh>& ray, const RayInput<Real>& input, Real step) {
  Vec3T<Real> sum{};
  Sighting<Real> out;
  for (int i = 0; i < ray.count; ++i) {
    const Vec3T<Real> at = input.origin + (ray.distance[i] * step) * input.direction +
                           displacement_of(ray.samples[i].warp.motion, ray.r[i]);
    sum += ray.weight[i] * at;
    out.alpha += ray.weight[i];
  }
  constexpr Real kNothing = Real(1e-4);
  if (!(out.alpha > kNothing)) return {};
  out.place = (Real(1) / out.alpha) * sum;
  return out;
}

/// Its adjoint: records for the motion slice. The samples' shares in the pixel are constants, as in Eq. 6,
/// and those below `min_weight` leave none, as in `backward`.
/// @param seen  what sighting_of gave. @param d_place  d loss / d place
template <class Real, int Sh, bool Jet>
void sighting_vjp(const RayKernel<Real, Sh>& ray, const Sighting<Real>& seen, const Vec3T<Real>& d_place,
                  Real min_weight, RayRecords<Real, RayKernel<Real, Sh>::kWidth, Jet>& out) {
  if (seen.alpha == 0) return;
  for (int i = ray.count - 1; i >= 0; --i) {
    const auto& warp = ray.samples[i].warp;
    const Real w = ray.weight[i];
    if (w < min_weight || warp.cell.is_frozen()) continue;
    auto& m = out.motion.emplace_back();
    m = {};
    m.cell = warp.cell;
    m.fraction = warp.fraction;
    displacement_vjp((w / seen.alpha) * d_place, warp.motion, ray.r[i], ray.r_slope[i], m.g);
  }
}

}  // namespace splinevox
