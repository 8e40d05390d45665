// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/gather.hpp"
#include "math/composite.hpp"
#include "render/motion_loss.hpp"
#include "render/ray_kernel.hpp"
#include "render/records.hpp"

namespace splinevox {

/// Reverse sweep of the ray a kernel just marched: turns d loss / d rgb into records for the radiance rows
/// and, through the derivatives of the interpolation weights, for the motion slice. For those the rows are
/// gathered again: in training only a quarter of the samples that forward shaded leaves a record.
///
/// Samples whose weight T alpha is below `min_weight` leave no record. With Adam, whose steps do not shrink
/// with the gradient, their tiny pushes would drive the density of empty space to where nothing could bring
/// it back. 0 keeps every sample.
///
/// @param prior  weight of transmittance_prior
/// @tparam Deep        whether the loss asks for the distance too. @param d_distance  its derivative by
/// expected_distance
template <bool Deep = false, class Real, int Sh, bool Moving, bool Jet>
void backward(const RayKernel<Real, Sh, Real, Moving>& ray, const RayInput<Real>& input,
              const RayResult<Real>& result, const FieldView<Real>& field, const Vec3T<Real>& d_rgb,
              Real min_weight, RayRecords<Real, RayKernel<Real, Sh>::kWidth, Jet>& out, Real prior = 0,
              [[maybe_unused]] Real d_distance = 0) {
  using K = RayKernel<Real, Sh, Real, Moving>;
  using Eight = typename K::Eight;
  using Vec = Vec3T<Real>;
  Real behind = composite_end(result.transmittance, input.background, d_rgb, prior);
  if constexpr (Deep)
    behind += channel_share(result.transmittance, Real(input.count) * field.step, d_distance);
  for (int i = ray.count - 1; i >= 0; --i) {
    const auto& s = ray.samples[i];
    const Emission<Real> emission = ray.emission(i);
    const Real w = ray.weight[i];
    const Real behind_this = behind;
    behind += composite_share(emission, w, d_rgb);
    if constexpr (Deep) behind += channel_share(w, ray.distance[i] * field.step, d_distance);
    if (w < min_weight) continue;
    EmissionAdjoint<Real> given =
        composite_vjp(emission, w, ray.transmittance_next[i], field.step, behind_this, d_rgb);
    if constexpr (Deep)
      given.density +=
          channel_vjp(ray.transmittance_next[i], field.step, ray.distance[i] * field.step, d_distance);
    const EmissionAdjoint<Real> d = emission_vjp(emission, given);

    auto& record = out.radiance.emplace_back();
    record.cell = s.radiance_cell;
    record.fraction = s.radiance_fraction;
    Eight g[K::kRegisters];
    for (int k = 0; k < K::kRegisters; ++k) {
      g[k] = row_vjp(d, ray.harmonics[k], k == 0);
      store(record.g + 8 * k, g[k]);
    }

    if constexpr (Moving) {
      if (s.warp.cell.is_frozen()) continue;
      const CellRows rows = field.radiance.rows(s.radiance_cell);
      Eight dx{}, dy{}, dz{};
      for (int k = 0; k < K::kRegisters; ++k) {
        const auto v = gather<Eight>(rows, s.radiance_fraction, field.radiance_rows, K::kWidth, 8 * k);
        dx += g[k] * v.dx;
        dy += g[k] * v.dy;
        dz += g[k] * v.dz;
      }
      const Vec d_delta = field.radiance.inv_spacing * Vec{sum8(dx), sum8(dy), sum8(dz)} +
                          rest_vjp(input.rest, w, displacement_of(s.warp.motion, ray.r[i]));
      auto& m = out.motion.emplace_back();
      m.cell = s.warp.cell;
      m.fraction = s.warp.fraction;
      displacement_vjp(d_delta, s.warp.motion, ray.r[i], ray.r_slope[i], m.g);
      for (int k = kSliceScalars; k < kSliceWidth; ++k) m.g[k] = 0;
      m.g[kSliceScalars + kLight] = d.light;
      m.g[kSliceScalars + kPresence] = d.density;
      if constexpr (Jet)
        for (auto& row : m.h)
          for (Real& v : row) v = 0;
    }
  }
}

/// How far from its sample 0 a ray ends on the mean, scene units: a distance is composited like a colour, and
/// what goes through the box ends behind it.
template <class Real, int Sh, bool Moving>
Real expected_distance(const RayKernel<Real, Sh, Real, Moving>& ray, const RayInput<Real>& input,
                       const RayResult<Real>& result, Real step) {
  Real sum = result.transmittance * Real(input.count);
  for (int i = 0; i < ray.count; ++i) sum += ray.weight[i] * ray.distance[i];
  return step * sum;
}

/// Adds the gradients of the offset and divergence losses to the motion records that `backward` wrote for
/// this ray with the same min_weight (`first` is the index of its first record, that of the last sample).
/// Visibility weights are constants here, as in the paper. Returns the summed value.
template <class Real, int Sh>
Real motion_losses(const RayKernel<Real, Sh>& ray, const FieldView<Real>& field, const FrameView<Real>& frame,
                   const MotionLoss<Real>& loss, const Vec3T<Real>& probe, Real min_weight, std::size_t first,
                   RayRecords<Real, RayKernel<Real, Sh>::kWidth, true>& out) {
  using Four = typename Simd<Real>::Four;
  Real value = 0;
  std::size_t next = first;
  for (int i = ray.count - 1; i >= 0; --i) {
    if (ray.weight[i] < min_weight) continue;
    const auto& s = ray.samples[i];
    const CellRows rows = field.motion.rows(s.warp.cell);
    const auto v = gather<Four>(rows, s.warp.fraction, frame.slice, kSliceWidth, 0);
    const Real inv = field.motion.inv_spacing, w = ray.weight[i];
    auto& record = out.motion[next++];
    value += motion_loss_sample(motion_jet(v, inv, ray.r[i], ray.r_slope[i]), loss, probe, w, inv, record.g,
                                record.h);
  }
  return value;
}

}  // namespace splinevox
