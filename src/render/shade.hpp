// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "core/pack.hpp"
#include "field/lattice/slice.hpp"
#include "math/composite.hpp"
#include "math/presence.hpp"
#include "math/sh.hpp"
#include "math/trilinear.hpp"
#include "math/warp.hpp"
#include "render/views.hpp"

namespace splinevox {

/// A position resolved on a lattice.
struct Place {
  Cell cell;
  Vec3 fraction;
};

/// Of sample `index` of a ray. In double, as exact as RayKernel's Course, whose parts a lane has no registers
/// for.
/// @param moved  vertices from the ray
SPLINEVOX_INLINE Place place_of(const BrickView<float>& view, const RayInput<float>& ray, int index,
                                float step, const Vec3& moved) {
  Place out;
  int base[3];
  SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) {
    const double along = (double(ray.origin[a]) - view.origin[a]) + index * (double(step) * ray.direction[a]);
    const double u = along * view.inv_spacing + moved[a];
    base[a] = int(view.clamped(float(u), a));
    out.fraction[a] = float(u - base[a]);
  }
  out.cell = view.cell(base[0], base[1], base[2]);
  return out;
}

/// Four columns of the rows around a place, interpolated, with their derivatives by the fractions.
SPLINEVOX_INLINE TrilinearValue<Pack> gather_pack(const CellRows& rows, const Vec3& fraction,
                                                  const float* values, int width, int offset) {
  const auto corner = [&](int c) { return load_pack(values + std::size_t(rows.row[c]) * width + offset); };
  return trilinear_with_gradient(fraction, corner(0), corner(1), corner(2), corner(3), corner(4), corner(5),
                                 corner(6), corner(7));
}

/// Harmonics of a direction in the columns of a radiance row: 4 columns of zero, the harmonics, zeros.
template <int Sh>
struct RowHarmonics {
  static constexpr int kCount = (Sh + 1) * (Sh + 1);
  float y[kCount > 0 ? kCount : 1];
  SPLINEVOX_HD explicit RowHarmonics(const Vec3& direction) {
    if constexpr (Sh >= 0) sh_basis(Sh, direction, y);
  }
  SPLINEVOX_INLINE float operator[](int column) const {
    return column >= 4 && column < 4 + kCount ? y[column - 4] : 0.0f;
  }
  /// Those of pack p of a row.
  SPLINEVOX_INLINE Pack pack(int p) const {
    Pack out;
    SPLINEVOX_UNROLL for (int c = 0; c < Pack::kSize; ++c) out[c] = (*this)[p * Pack::kSize + c];
    return out;
  }
};

/// One sample of a ray, alone: what RayKernel does for many at once, for executors whose lanes are samples.
/// Formulas and the order of their sums are the same.
///
/// @tparam Sh, Moving  as RayKernel.
template <int Sh, bool Moving>
struct Shaded {
  static constexpr int kWidth = radiance_width(Sh), kPacks = kWidth / Pack::kSize;
  bool stored;  ///< any corner is; if not, the sample is empty and nothing below but alpha and passed is set
  float alpha, passed;  ///< Opacity of the step
  Emission<float> emission;
  Place at;  ///< in the radiance lattice, after the warp
  /// A long row's slopes would not fit into a device's registers: they are gathered again when they are
  /// needed.
  static constexpr bool kKeepsSlopes = kPacks <= 2;
  Pack slope[kKeepsSlopes ? kPacks : 1][3];          ///< d row / d fraction
  std::conditional_t<Moving, Place, char> observed;  ///< in the motion lattice, before it
  Pack motion;                                       ///< Delta_0 and raw rigidity
  float r, r_slope;                                  ///< rigidity
};

template <int Sh, bool Moving>
SPLINEVOX_INLINE Shaded<Sh, Moving> shade_sample(const RayInput<float>& ray, int index,
                                                 const FieldView<float>& field, const FrameView<float>& frame,
                                                 const RowHarmonics<Sh>& harmonics) {
  using Out = Shaded<Sh, Moving>;
  Out s;
  s.alpha = 0;
  s.passed = 1;
  Vec3 moved{};
  Activated<float> gain{1, 0};
  float presence = 0;
  s.r = 1;
  s.r_slope = 0;
  if constexpr (Moving) {
    s.observed = place_of(field.motion, ray, index, field.step, moved);
    const CellRows rows = field.motion.rows(s.observed.cell);
    float w[kCorners];
    trilinear_weights(s.observed.fraction, w);
    s.motion = {};
    Pack scalars{};
    SPLINEVOX_UNROLL for (int c = 0; c < kCorners; ++c) {
      const float* row = frame.slice + std::size_t(rows.row[c]) * kSliceWidth;
      s.motion += w[c] * load_pack(row);
      SPLINEVOX_UNROLL for (int i = 0; i < kScalars; ++i) scalars[i] += w[c] * row[kSliceScalars + i];
    }
    gain = light_gain(scalars[kLight]);
    presence = scalars[kPresence];
    if (field.rigidity) {
      const Activated<float> r = rigidity_of(s.motion[3], field.rigidity_offset);
      s.r = r.value;
      s.r_slope = r.slope;
    }
    moved = displacement_of(s.motion, s.r) * field.radiance.inv_spacing;
  }
  s.at = place_of(field.radiance, ray, index, field.step, moved);
  const CellRows rows = field.radiance.rows(s.at.cell);
  s.stored = false;
  SPLINEVOX_UNROLL for (int c = 0; c < kCorners; ++c) s.stored |= rows.row[c] >= kBrickRows;
  if (!s.stored) return s;

  RawSample<float> raw;
  SPLINEVOX_UNROLL for (int k = 0; k < Out::kPacks;
                        k +=
                        2) {  // a register of eight is two of four; its lanes are summed in the order of sum8
    Pack sum{};
    SPLINEVOX_UNROLL for (int half = 0; half < 2; ++half) {
      const int p = k + half;
      const TrilinearValue<Pack> v =
          gather_pack(rows, s.at.fraction, field.radiance_rows, Out::kWidth, p * Pack::kSize);
      if constexpr (Out::kKeepsSlopes) {
        s.slope[p][0] = v.dx;
        s.slope[p][1] = v.dy;
        s.slope[p][2] = v.dz;
      }
      if (p == 0) {
        raw.density = present(v.value[0], presence);
        raw.color = {v.value[1], v.value[2], v.value[3]};
      } else if constexpr (Sh >= 0)
        SPLINEVOX_UNROLL for (int c = 0; c < 4; ++c) sum[c] += v.value[c] * harmonics[p * Pack::kSize + c];
    }
    if constexpr (Sh >= 0) raw.view += (sum[0] + sum[2]) + (sum[1] + sum[3]);
  }
  s.emission = emission_of<(Sh >= 0)>(raw, field.density_scale, field.density_shift);
  s.emission.light = gain.value;
  s.emission.light_slope = gain.slope;
  const Opacity<float> opacity = opacity_of(s.emission.sigma, field.step);
  s.alpha = opacity.alpha;
  s.passed = opacity.passed;
  return s;
}

/// Gradients of one sample's rows: what Record holds, as values.
template <int Sh>
struct SampleGradient {
  Pack radiance[Shaded<Sh, true>::kPacks];
  Pack motion;   ///< Delta_0 and raw rigidity
  Pack scalars;  ///< the curves of one number
};

/// From the adjoint of the composite to the rows: harmonics of the view factor, and through the slopes of the
/// interpolation to the displacement.
/// @param ray  as given, in memory: registers are few.   @param share  of the sample in the pixel.
template <int Sh, bool Moving>
SPLINEVOX_INLINE SampleGradient<Sh> sample_vjp(const Shaded<Sh, Moving>& s, const EmissionAdjoint<float>& d,
                                               const FieldView<float>& field,
                                               const RowHarmonics<Sh>& harmonics, const RayInput<float>& ray,
                                               float share) {
  using Row = Shaded<Sh, Moving>;
  SampleGradient<Sh> out;
  Pack along[3] = {};
  const CellRows rows = Moving && !Row::kKeepsSlopes ? field.radiance.rows(s.at.cell) : CellRows{};
  SPLINEVOX_UNROLL for (int p = 0; p < Row::kPacks; ++p) {
    Pack& g = out.radiance[p];
    g = row_vjp(d, harmonics.pack(p), p == 0);
    if constexpr (Moving) {
      const Pack* slope = s.slope[0];
      Pack again[3];
      if constexpr (Row::kKeepsSlopes) {
        slope = s.slope[p];
      } else {
        const TrilinearValue<Pack> v =
            gather_pack(rows, s.at.fraction, field.radiance_rows, Row::kWidth, p * Pack::kSize);
        again[0] = v.dx;
        again[1] = v.dy;
        again[2] = v.dz;
        slope = again;
      }
      SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) SPLINEVOX_UNROLL for (int c = 0; c < 4; ++c) along[a][c] +=
          g[c] * slope[a][c];
    }
  }
  if constexpr (Moving) {
    Vec3 delta;
    SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) delta[a] =
        field.radiance.inv_spacing * ((along[a][0] + along[a][2]) + (along[a][1] + along[a][3]));
    // Without a branch, also where nothing is asked: with one, the longest rows spill on a device.
    delta = delta + rest_vjp(ray.rest, share, displacement_of(s.motion, s.r));
    displacement_vjp(delta, s.motion, s.r, s.r_slope, out.motion);
    out.scalars[kLight] = d.light;
    out.scalars[kPresence] = d.density;
  }
  return out;
}

}  // namespace splinevox
