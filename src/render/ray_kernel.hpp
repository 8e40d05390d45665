// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/simd.hpp"
#include "field/lattice/gather.hpp"
#include "field/lattice/slice.hpp"
#include "math/composite.hpp"
#include "math/presence.hpp"
#include "math/sh.hpp"
#include "math/trilinear.hpp"
#include "math/warp.hpp"
#include "render/ray_course.hpp"
#include "render/views.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// What a ray composites to (Eq. 1).
template <class Real>
struct RayResult {
  Vec3T<Real> rgb{};       ///< over the ray's background
  Real transmittance = 1;  ///< left at the end of the ray
};

/// Forward march of one ray through a frame. Keeps what the backward sweep needs, as arrays over the visible
/// samples, so that the arithmetic between the gathers is plain loops the compiler turns into vector code.
/// One instance per task, reused.
///
/// @tparam Sh      spherical harmonic order of the view rescale, -1 for none.
/// @tparam Moving  whether anything changes over time; if not, the kernel reads no slice and keeps nothing of
/// motion.
template <class Real, int Sh, class Stored = Real, bool Moving = true>
class RayKernel {
 public:
  static constexpr int kShCount = (Sh + 1) * (Sh + 1);
  static constexpr int kWidth = radiance_width(Sh);
  static constexpr int kRegisters = kWidth / 8;
  static constexpr int kChunk = 16;  ///< samples processed together; also the prefetch distance
  using Four = typename Simd<Real>::Four;
  using Eight = typename Simd<Real>::Eight;
  using Vec = Vec3T<Real>;
  using Field = FieldView<Real, Stored>;
  using Course = RayCourse<Real>;

  /// Marches until the box ends or transmittance falls below `stop`; the sample that crosses is the last one
  /// counted.
  RayResult<Real> forward(const RayInput<Real>& ray, const Field& field, const FrameView<Real>& frame,
                          Real stop) {
    count = 0;
    visited = 0;
    transmittance_ = 1;
    rgb_ = {};
    sh_basis_padded(ray.direction);
    radiance_course_ = Course(field.radiance, ray, field.step);
    if constexpr (Moving) motion_course_.reset();
    int pending = 0;
    for (int i0 = 0; i0 < ray.count; i0 += kChunk) {
      pending = find_occupied(ray, field, frame.occupancy, i0, pending);
      const bool last = i0 + kChunk >= ray.count;
      while (pending >= kChunk || (last && pending > 0)) {
        const int n = std::min(pending, kChunk);
        if (shade_chunk(ray, field, frame, n, stop)) return finish(ray);
        pending -= n;
        std::copy(index_ + n, index_ + n + pending, index_);
        if constexpr (Moving) std::copy(reads_ + n, reads_ + n + pending, reads_);
      }
    }
    return finish(ray);
  }

  int count = 0;    ///< samples of the last ray that lie in stored bricks, in order along it
  int visited = 0;  ///< samples that lay in occupied cells

  /// Where a sample lies in the motion lattice, and what it read there.
  struct Warp {
    Cell cell;  ///< Cell::frozen(): nothing was read, motion is 0
    Vec fraction;
    Four motion;  ///< Delta_0 and raw rigidity
  };
  struct NoWarp {};
  /// Per-sample values kept for the backward sweep; [count] each.
  struct Sample {
    Cell radiance_cell;
    Vec radiance_fraction;
    [[no_unique_address]] std::conditional_t<Moving, Warp, NoWarp> warp;
  };
  std::vector<Sample> samples;
  AlignedVector<Real> light, light_slope;          ///< gain of the light
  AlignedVector<Real> r, r_slope;                  ///< rigidity
  AlignedVector<Real> sigma_slope;                 ///< d sigma / d raw density
  AlignedVector<Real> base[3], base_slope[3];      ///< sigmoid(rgb)
  AlignedVector<Real> view, view_slope;            ///< view factor
  AlignedVector<Real> weight, transmittance_next;  ///< T_i alpha_i, T_{i+1}
  AlignedVector<Real> distance;                    ///< sample index along the ray
  Eight harmonics[kRegisters];                     ///< Y_j(direction) in the lanes of the row's coefficients

  /// What sample i of the last ray gives off; its density is not kept.
  Emission<Real> emission(int i) const {
    Emission<Real> e;
    e.sigma_slope = sigma_slope[i];
    for (int c = 0; c < 3; ++c) {
      e.base[c] = base[c][i];
      e.base_slope[c] = base_slope[c][i];
    }
    if constexpr (Sh >= 0) {
      e.view = view[i];
      e.view_slope = view_slope[i];
    }
    if constexpr (Moving) {
      e.light = light[i];
      e.light_slope = light_slope[i];
    }
    return e;
  }

 private:
  void sh_basis_padded(const Vec& d) {
    Real y[kMaxShCount + 8] = {}, lanes[kWidth] = {};
    if constexpr (Sh >= 0) sh_basis(Sh, d, y);
    for (int j = 0; j < kShCount; ++j) lanes[4 + j] = y[j];
    for (int k = 0; k < kRegisters; ++k) harmonics[k] = load<Eight>(lanes + 8 * k);
  }

  void reserve(int n) {
    if (int(samples.size()) >= n) return;
    n = (n + 255) / 256 * 256;
    samples.resize(n);
    for (auto* a :
         {&light, &light_slope, &r, &r_slope, &sigma_slope, &base[0], &base[1], &base[2], &base_slope[0],
          &base_slope[1], &base_slope[2], &view, &view_slope, &weight, &transmittance_next, &distance})
      a->resize(n);
  }

  /// Appends the occupied samples of [i0, i0 + kChunk) to index_, and whether they read motion to reads_.
  int find_occupied(const RayInput<Real>& ray, const Field& field, const OccupancyView<Real>& grid, int i0,
                    int pending) {
    const int n = std::min(kChunk, ray.count - i0);
    if (!grid.bits) {
      for (int j = 0; j < n; ++j, ++pending) {
        index_[pending] = i0 + j;
        reads_[pending] = 1;
      }
      return pending;
    }
    std::uint32_t cell[kChunk], hit[kChunk];
    const Vec o = (ray.origin - grid.origin) * grid.inv_cell,
              d = ray.direction * (field.step * grid.inv_cell);
    for (int j = 0; j < kChunk; ++j) {
      const Real i = Real(i0 + j);
      int x = int(o.x + i * d.x), y = int(o.y + i * d.y), z = int(o.z + i * d.z);
      x = std::clamp(x, 0, grid.size.x - 1);
      y = std::clamp(y, 0, grid.size.y - 1);
      z = std::clamp(z, 0, grid.size.z - 1);
      cell[j] = std::uint32_t((x * grid.size.y + y) * grid.size.z + z);
      hit[j] = grid.bits[cell[j] >> 5] >> (cell[j] & 31) & 1;
    }
    [[maybe_unused]] std::uint32_t reads[kChunk];
    if constexpr (Moving) {
      if (field.reach)
        for (int j = 0; j < kChunk; ++j) reads[j] = field.reach[cell[j] >> 5] >> (cell[j] & 31) & 1;
      else
        std::fill_n(reads, kChunk, 1u);
    }
    for (int j = 0; j < n; ++j) {
      index_[pending] = i0 + j;
      if constexpr (Moving) reads_[pending] = reads[j];
      pending += int(hit[j]);
    }
    return pending;
  }

  RayResult<Real> finish(const RayInput<Real>& ray) const {
    return {rgb_ + transmittance_ * ray.background, transmittance_};
  }

  /// Fractions and cells of kChunk positions in a lattice.
  struct Located {
    alignas(64) Real fraction[3][kChunk];
    alignas(64) std::int32_t vertex[3][kChunk];
    Vec at(int j) const { return {fraction[0][j], fraction[1][j], fraction[2][j]}; }
  };
  /// @param moved  vertices from the ray. Of what lies outside the lattice only the cell has a meaning: there
  /// is nothing in it.
  static void locate(const BrickView<Real>& view, const Course& course, const Real (&i)[kChunk],
                     const Real (&moved)[3][kChunk], Located& out) {
    for (int a = 0; a < 3; ++a) {
      const Real coarse_from = course.coarse[a], coarse_by = course.coarse_step[a],
                 fine_from = course.fine[a], fine_by = course.fine_step[a];
      for (int j = 0; j < kChunk; ++j) {
        const Real coarse = coarse_from + i[j] * coarse_by, fine = fine_from + i[j] * fine_by + moved[a][j];
        const std::int32_t base_vertex = std::int32_t(view.clamped(coarse + fine, a));
        out.vertex[a][j] = base_vertex;
        out.fraction[a][j] = (coarse - Real(base_vertex)) + fine;
      }
    }
  }
  static Cell cell_of(const BrickView<Real>& view, const Located& at, int j) {
    return view.cell(at.vertex[0][j], at.vertex[1][j], at.vertex[2][j]);
  }

  /// What kChunk samples read of motion. One that reads nothing is displaced by nothing, its light has gain
  /// 1, and its presence is 0.
  struct Warped {
    Cell cell[kChunk];
    Vec fraction[kChunk];
    Four motion[kChunk];
    alignas(64) Real r[kChunk], r_slope[kChunk], light[kChunk], light_slope[kChunk], presence[kChunk];
  };
  /// @param i  samples of the ray. @param moved  gets their displacements, in vertices of the radiance
  /// lattice.
  void warp(const RayInput<Real>& ray, const Field& field, const FrameView<Real>& frame,
            const Real (&i)[kChunk], int n, Warped& out, Real (&moved)[3][kChunk]) {
    alignas(64) Real raw_light[kChunk] = {}, raw_r[kChunk] = {};
    std::fill_n(out.presence, kChunk, Real(0));
    if (!gather_motion(ray, field, frame, i, n, out, raw_light)) {
      std::fill_n(out.r, kChunk,
                  field.rigidity ? rigidity_of(Real(0), field.rigidity_offset).value : Real(1));
      std::fill_n(out.r_slope, kChunk, Real(0));
      std::fill_n(out.light, kChunk, Real(1));
      std::fill_n(out.light_slope, kChunk, Real(0));
      return;
    }
    activate(raw_light, out.light, out.light_slope, [](Real x) { return light_gain(x); });
    if (field.rigidity) {
      for (int j = 0; j < n; ++j) raw_r[j] = out.motion[j][3];
      activate(raw_r, out.r, out.r_slope, [&](Real x) { return rigidity_of(x, field.rigidity_offset); });
    } else {
      std::fill_n(out.r, kChunk, Real(1));
      std::fill_n(out.r_slope, kChunk, Real(0));
    }
    for (int j = 0; j < n; ++j) {
      const Vec vertices = displacement_of(out.motion[j], out.r[j]) * field.radiance.inv_spacing;
      for (int a = 0; a < 3; ++a) moved[a][j] = vertices[a];
    }
  }

  /// Whether any of the first n pending samples reads motion.
  bool gather_motion(const RayInput<Real>& ray, const Field& field, const FrameView<Real>& frame,
                     const Real (&i)[kChunk], int n, Warped& out, Real* raw_light) {
    std::uint32_t any = 0;
    for (int j = 0; j < n; ++j) any |= reads_[j];
    Located at;
    if (any) {
      if (!motion_course_) motion_course_.emplace(field.motion, ray, field.step);
      constexpr Real kUnmoved[3][kChunk] = {};
      locate(field.motion, *motion_course_, i, kUnmoved, at);
    }
    for (int j = 0; j < n; ++j) {
      if (!reads_[j]) {
        out.cell[j] = Cell::frozen();
        out.fraction[j] = {};
        out.motion[j] = Four{};
        continue;
      }
      out.cell[j] = cell_of(field.motion, at, j);
      out.fraction[j] = at.at(j);
      const CellRows rows = field.motion.rows(out.cell[j]);
      Real w[kCorners];
      trilinear_weights(out.fraction[j], w);
      Eight sum{};
      for (int c = 0; c < kCorners; ++c)
        sum += w[c] * load<Eight>(frame.slice + std::size_t(rows.row[c]) * kSliceWidth);
      out.motion[j] = Four{sum[0], sum[1], sum[2], sum[3]};
      raw_light[j] = sum[kSliceScalars + kLight];
      out.presence[j] = sum[kSliceScalars + kPresence];
    }
    return any != 0;
  }

  /// Warps, gathers, activates and composites the first n pending samples. Returns true when the ray is
  /// opaque.
  bool shade_chunk(const RayInput<Real>& ray, const Field& field, const FrameView<Real>& frame, int n,
                   Real stop) {
    reserve(count + 2 * kChunk);
    visited += n;
    alignas(64) Real moved[3][kChunk] = {}, i_real[kChunk];
    for (int j = 0; j < kChunk; ++j) i_real[j] = Real(index_[std::min(j, n - 1)]);
    [[maybe_unused]] Warped warped;
    if constexpr (Moving) warp(ray, field, frame, i_real, n, warped, moved);

    Located at;
    locate(field.radiance, radiance_course_, i_real, moved, at);
    // Keep only samples with a stored corner; start fetching their rows.
    CellRows rows[kChunk];
    alignas(64) Real presence[kChunk] = {};
    int kept = 0;
    for (int j = 0; j < n; ++j) {
      const Cell cell = cell_of(field.radiance, at, j);
      const CellRows cr = field.radiance.rows(cell);
      bool stored = cr.row[0] >= kBrickRows;
      if (!stored && !cell.interior())
        for (int c = 1; c < kCorners; ++c) stored |= cr.row[c] >= kBrickRows;
      if (!stored) continue;
      for (int c = 0; c < kCorners; ++c)
        for (std::size_t line = 0; line < kWidth * sizeof(Stored); line += 64)
          __builtin_prefetch(
              reinterpret_cast<const char*>(field.radiance_rows + std::size_t(cr.row[c]) * kWidth) + line);
      Sample& s = samples[count + kept];
      s.radiance_cell = cell;
      s.radiance_fraction = at.at(j);
      distance[count + kept] = i_real[j];
      if constexpr (Moving) {
        s.warp = {warped.cell[j], warped.fraction[j], warped.motion[j]};
        light[count + kept] = warped.light[j];
        light_slope[count + kept] = warped.light_slope[j];
        presence[kept] = warped.presence[j];
        r[count + kept] = warped.r[j];
        r_slope[count + kept] = warped.r_slope[j];
      }
      rows[kept++] = cr;
    }
    if (kept == 0) return false;
    return shade_stored(field, rows, presence, kept, stop);
  }

  /// Values and derivatives of a formula over a chunk.
  template <class Formula>
  SPLINEVOX_INLINE static void activate(const Real (&raw)[kChunk], Real* value, Real* slope,
                                        const Formula& formula) {
    for (int j = 0; j < kChunk; ++j) {
      const Activated<Real> s = formula(raw[j]);
      value[j] = s.value;
      slope[j] = s.slope;
    }
  }

  bool shade_stored(const Field& field, const CellRows* rows, const Real (&presence)[kChunk], int n,
                    Real stop) {
    alignas(64) Real raw[5][kChunk] = {};  // density, r, g, b, view
    for (int j = 0; j < n; ++j) {
      const Sample& s = samples[count + j];
      Real view_raw = 0;
      for (int k = 0; k < kRegisters; ++k) {
        const Eight v = gather<Eight>(rows[j], s.radiance_fraction, field.radiance_rows, kWidth, 8 * k).value;
        if (k == 0)
          for (int c = 0; c < 4; ++c) raw[c][j] = v[c];
        if constexpr (Sh >= 0) view_raw += sum8(v * harmonics[k]);
      }
      if constexpr (Moving) raw[0][j] = present(raw[0][j], presence[j]);
      raw[4][j] = view_raw;
    }

    // emission_of, a loop for each part: the compiler does not turn one for all into vector code.
    alignas(64) Real alpha[kChunk], passed[kChunk];
    Real* const at_sigma_slope = sigma_slope.data() + count;
    for (int j = 0; j < kChunk; ++j) {
      const Activated<Real> s = density_of(raw[0][j], field.density_scale, field.density_shift);
      const Opacity<Real> o = opacity_of(s.value, field.step);
      at_sigma_slope[j] = s.slope;
      alpha[j] = o.alpha;
      passed[j] = o.passed;
    }
    for (int c = 0; c < 3; ++c)
      activate(raw[1 + c], base[c].data() + count, base_slope[c].data() + count,
               [](Real x) { return color_of(x); });
    if constexpr (Sh >= 0)
      activate(raw[4], view.data() + count, view_slope.data() + count, [](Real x) { return view_factor(x); });

    for (int j = 0; j < n; ++j, ++count) {
      weight[count] = composite_sample(emission(count), alpha[j], transmittance_, rgb_);
      transmittance_ *= passed[j];
      transmittance_next[count] = transmittance_;
      if (ray_ends(transmittance_, stop)) {
        ++count;
        return true;
      }
    }
    return false;
  }

  int index_[3 * kChunk];
  std::uint32_t reads_[3 * kChunk];  ///< 0: nothing of motion
  Course radiance_course_;
  std::optional<Course> motion_course_;  ///< of a ray that has read motion
  Real transmittance_ = 1;
  Vec rgb_{};
};

/// For fields in which nothing changes over time.
template <class Real, int Sh>
using StillKernel = RayKernel<Real, Sh, Real, false>;

}  // namespace splinevox
