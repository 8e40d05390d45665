// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/atomic.hpp"
#include "core/pack.hpp"
#include "core/rng.hpp"
#include "field/columns.hpp"
#include "field/lattice/lattice_view.hpp"
#include "math/adam.hpp"
#include "math/curve_prior.hpp"
#include "math/shrink.hpp"
#include "math/tv.hpp"

namespace splinevox {

/// Whether a step's draw takes a brick for total variation.
SPLINEVOX_HD inline bool chosen_brick(std::uint64_t draw, int brick, float share) {
  return Rng(draw, 6).uniform(std::uint64_t(brick)) < share;
}

/// Floats of a row above which columns without a gradient are passed over: of a long spline a step sees a few
/// pieces only.
inline constexpr int kLongRow = 128;

struct PlainRoot {
  SPLINEVOX_HD float operator()(float x) const { return std::sqrt(x); }
};
/// Moments too small to matter; see adam_step.
struct PlainFlush {
  SPLINEVOX_HD float operator()(float x, float least) const { return (x < 0 ? -x : x) < least ? 0.0f : x; }
};

/// One pack of one row of a chosen brick: gradient of total variation, its own term and those of the three
/// vertices below it. Rows that are not visible are as if absent.
struct TvKernel {
  const float* values;
  const float* weight;  ///< [width] scale * tv / share
  float* gradient;      ///< added to
  std::uint64_t* touched;
  const std::uint64_t* visible;  ///< LearnedRows::visible; null: every row is
  LatticeView lattice;
  int width;
  float share;
  std::uint64_t draw;

  SPLINEVOX_HD std::size_t count() const { return lattice.rows() * std::size_t(width / Pack::kSize); }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    const int packs = width / Pack::kSize, offset = int(i % packs) * Pack::kSize;
    const std::size_t row = i / packs;
    const int brick = int(row / kBrickRows);
    if (brick == 0 || !chosen_brick(draw, brick, share)) return;
    if (offset == 0 && row % 64 == 0) touched[row >> 6] |= visible ? visible[row >> 6] : ~std::uint64_t(0);
    if (!present(row)) return;
    const Int3 v = lattice.vertex(row);
    Term own(*this, v, offset);
    Pack d{};
    for (int c = 0; c < Pack::kSize; ++c) d[c] = own.at(c).d_self;
    SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) {
      const Int3 u{v.x - (a == 0), v.y - (a == 1), v.z - (a == 2)};
      if (!present(lattice.row_of(u))) continue;
      const Term below(*this, u, offset);
      for (int c = 0; c < Pack::kSize; ++c) {
        const TvTerm<float> t = below.at(c);
        d[c] += a == 0 ? t.d_x : a == 1 ? t.d_y : t.d_z;
      }
    }
    float* to = gradient + row * width + offset;
    Pack sum = load_pack(to);
    for (int c = 0; c < Pack::kSize; ++c) sum[c] += weight[offset + c] * d[c];
    store_pack(to, sum);
  }

 private:
  SPLINEVOX_HD bool present(std::size_t row) const {
    return row >= kBrickRows && (!visible || test_row(visible, row));
  }
  /// The values of a vertex and of its three neighbours above, itself where one is absent.
  struct Term {
    Pack self, x, y, z;
    SPLINEVOX_HD Term(const TvKernel& k, const Int3& v, int offset) {
      const std::size_t own = k.lattice.row_of(v);
      const auto read = [&](std::size_t row) {
        return load_pack(k.values + (k.present(row) ? row : own) * k.width + offset);
      };
      self = read(own);
      x = read(k.lattice.row_of({v.x + 1, v.y, v.z}));
      y = read(k.lattice.row_of({v.x, v.y + 1, v.z}));
      z = read(k.lattice.row_of({v.x, v.y, v.z + 1}));
    }
    SPLINEVOX_HD TvTerm<float> at(int c) const {
      return tv_term(self[c], x[c], y[c], z[c], kTvSoftening, PlainRoot());
    }
  };
};

/// One row of a chosen brick: gradient of the prior on its curve.
template <class Prior>
struct CurvePriorKernel {
  const float* values;
  float* gradient;  ///< added to
  std::uint64_t* touched;
  std::size_t rows;
  const std::uint64_t* among;  ///< rows that the prior acts on; null: all
  int width, stride, stored_points;
  bool pinned;  ///< see curve_length_vjp
  Prior prior;
  float share;
  std::uint64_t draw;

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t row) const {
    const int brick = int(row / kBrickRows);
    if (brick == 0 || !chosen_brick(draw, brick, share)) return;
    if (row % 64 == 0) touched[row >> 6] |= among ? among[row >> 6] : ~std::uint64_t(0);
    if (!among || test_row(among, row))
      curve_prior_vjp(prior, values + row * width, stride, stored_points, pinned, share,
                      gradient + row * width);
  }
};

/// One touched row: sums in fixed point become floats, and are cleared.
struct DecodeKernel {
  std::int64_t* fixed;
  float* values;  ///< added to
  const std::uint64_t* touched;
  std::size_t rows;
  int width;
  double unit;  ///< value of one

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t row) const {
    if (!test_row(touched, row)) return;
    for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
      values[i] += float(double(fixed[i]) * unit);
      fixed[i] = 0;
    }
  }
};

/// One touched row: counted if any of its numbers cannot be used.
struct CheckKernel {
  const float* gradient;
  const std::uint64_t* touched;
  std::int64_t* bad_rows;
  std::size_t rows;
  int width;
  float largest;

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t row) const {
    if (!test_row(touched, row)) return;
    bool good = true;
    for (std::size_t i = row * width; i < (row + 1) * width; ++i)
      good &= gradient[i] < largest && gradient[i] > -largest;
    if (!good) atomic_add(bad_rows, std::int64_t(1));
  }
};

/// One touched row: an Adam step and the shrinkage of its groups, unless something spoilt the step; clears
/// the gradient. The mask is cleared by whoever owns it.
struct UpdateKernel {
  static constexpr int kGroups = kCurves;

  float *values, *gradient, *m, *v;
  const float* rate;  ///< [width]
  const std::uint64_t* touched;
  const std::int64_t* bad;  ///< rays and rows that are not usable: all zero, or nothing is changed
  std::size_t rows;
  int width, groups;
  const float* member[kGroups];  ///< [width] 1 for columns of the group, else 0
  float threshold[kGroups];
  MomentFactors factors;
  float rate_scale;

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t row) const {
    if (!test_row(touched, row)) return;
    const std::size_t first = row * width;
    const bool good = bad[0] == 0 && bad[1] == 0;
    for (int k = 0; k < width; k += 2 * Pack::kSize) {
      const Pack low = load_pack(gradient + first + k), high = load_pack(gradient + first + k + Pack::kSize);
      if (good && !(width > kLongRow && all_zero(low) && all_zero(high))) {
        step(first, k, low);
        step(first, k + Pack::kSize, high);
      }
      store_pack(gradient + first + k, {});
      store_pack(gradient + first + k + Pack::kSize, {});
    }
    if (!good) return;
    for (int g = 0; g < groups; ++g) {
      float squares = 0;
      for (int k = 0; k < width; ++k) {
        const float x = values[first + k] * member[g][k];
        squares += x * x;
      }
      const float share = garrote_share(std::sqrt(squares), rate_scale * threshold[g]);
      for (int k = 0; k < width; ++k) values[first + k] *= 1.0f - share * member[g][k];
    }
  }

 private:
  SPLINEVOX_HD static bool all_zero(const Pack& p) {
    return p[0] == 0 && p[1] == 0 && p[2] == 0 && p[3] == 0;
  }
  SPLINEVOX_HD void step(std::size_t first, int k, const Pack& g) const {
    Pack mm = load_pack(m + first + k), vv = load_pack(v + first + k), pp = load_pack(values + first + k);
    SPLINEVOX_UNROLL for (int c = 0; c < Pack::kSize; ++c)
        adam_step(factors, rate_scale * rate[k + c], g[c], mm[c], vv[c], pp[c], PlainRoot(), PlainFlush());
    store_pack(m + first + k, mm);
    store_pack(v + first + k, vv);
    store_pack(values + first + k, pp);
  }
};

/// 64 rows: those that the step's rays made visible are kept, unless something spoilt the step. Clears them.
struct KeepMarksKernel {
  std::uint64_t *visible, *marks;
  const std::int64_t* bad;  ///< see UpdateKernel
  std::size_t words;

  SPLINEVOX_HD std::size_t count() const { return words; }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    if (bad[0] == 0 && bad[1] == 0) visible[i] |= marks[i];
    marks[i] = 0;
  }
};

}  // namespace splinevox
