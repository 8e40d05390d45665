// SPDX-License-Identifier: Apache-2.0
#include "field/lattice/slice.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/simd.hpp"
#include "field/lattice/levels.hpp"
#include "field/lattice/row_slope.hpp"

namespace splinevox {
namespace {

using Four = Simd<float>::Four;

/// Place within a point of the curve that one register reads along with x, y and z. If there is none the
/// register reads what comes next in the row, which is not used.
constexpr int kBesidePlace = 3;

/// The control points [first, last) whose weight is not zero: at most four of a B-spline.
struct Range {
  int first = 0, last = 0;
  Range(const BasisWeights<float>& w, int stored) : last(stored) {
    while (last > 0 && w[last - 1] == 0) --last;
    while (first < last && w[first] == 0) ++first;
  }
};

BasisWeights<float> rounded(const MotionField& motion, const BasisWeights<double>& all, double scale) {
  const int first = motion.points - motion.stored_points();
  BasisWeights<float> w{};
  for (int k = first; k < motion.points; ++k) w[k - first] = float(scale * all[k]);
  return w;
}

}  // namespace

int stored_floats(const MotionField& motion) {
  int used = 0;
  for (const ColumnFacts& c : kColumns)
    if (c.of_motion() && motion.*c.stored) used = std::max(used, c.slice + c.width);
  return used;
}

BasisWeights<float> mean_weights(const MotionField& motion) {
  const Basis& basis = basis_of(motion.basis);
  BasisWeights<double> sum{};
  if (!basis.local) {
    std::fill_n(sum.begin(), motion.points,
                1.0 / motion.points);  // Bernstein polynomials have equal integrals
    return rounded(motion, sum, 1);
  }
  const int halves = 2 * basis.pieces(motion.points);
  for (int i = 0; i <= halves; ++i) {
    const BasisWeights<double> w = basis.weights(motion.points, double(i) / halves);
    const double share = (i % 2 == 1 ? 4.0 : i == 0 || i == halves ? 1.0 : 2.0) / (3.0 * halves);
    for (int k = 0; k < motion.points; ++k) sum[k] += share * w[k];
  }
  return rounded(motion, sum, 1);
}

Contraction::Contraction(const MotionField& motion)
    : layout(motion),
      count(motion.stored_points()),
      mean(motion.presence ? mean_weights(motion) : BasisWeights<float>{}) {}

float Contraction::mean_at(const float* points) const {
  float sum = 0;
  for (int k = 0; k < count; ++k) sum += mean[k] * points[layout.stride * k];
  return sum;
}

BasisWeights<float> parameter_weights(const MotionField& motion, double s) {
  return rounded(motion, basis_of(motion.basis).weights(motion.points, s), 1);
}

BasisWeights<float> parameter_weights_dt(const MotionField& motion, double s) {
  return rounded(motion, basis_of(motion.basis).weights_dt(motion.points, s), 1);
}

BasisWeights<float> stored_weights(const MotionField& motion, double t) {
  return parameter_weights(motion, motion.time_curve(t));
}

BasisWeights<float> stored_weights_dt(const MotionField& motion, double t) {
  return rounded(motion, basis_of(motion.basis).weights_dt(motion.points, motion.time_curve(t)),
                 motion.time_curve.slope(t));
}

void contract_brick(const Contraction& by, const Channels& level,
                    std::span<const BasisWeights<float>> weights, int brick, const RowMask& rows,
                    std::span<float* const> out) {
  const MotionLayout& layout = by.layout;
  std::vector<Range> points;
  for (const BasisWeights<float>& w : weights) points.emplace_back(w, by.count);
  const int presence = layout.scalar[kPresence];
  rows.for_each([&](int i) {
    const std::size_t r = std::size_t(brick) * kBrickRows + i;
    const float* row = level.row(r);
    const float mean = presence >= 0 ? by.mean_at(row + presence) : 0.0f;
    for (std::size_t f = 0; f < weights.size(); ++f) {
      Four sum{}, scalars{};
      if (layout.displaces)
        for (int k = points[f].first; k < points[f].last; ++k)
          sum += weights[f][k] * load<Four>(row + layout.stride * k);
      for (int c = 0; c < kScalars; ++c) {
        if (layout.scalar[c] == kBesidePlace && layout.displaces)
          scalars[c] = sum[kBesidePlace];
        else if (layout.scalar[c] >= 0)
          for (int k = points[f].first; k < points[f].last; ++k)
            scalars[c] += weights[f][k] * row[layout.stride * k + layout.scalar[c]];
      }
      scalars[kPresence] -= mean;
      sum[3] = layout.rigidity ? row[layout.rigidity_column] : 0.0f;
      store(out[f] + r * kSliceWidth, sum);
      store(out[f] + r * kSliceWidth + kSliceScalars, scalars);
    }
  });
}

void expand_brick(const Contraction& by, const BasisWeights<float>& weights, const RowMask& rows,
                  float* slice_gradient, int brick, Channels& gradient) {
  const MotionLayout& layout = by.layout;
  const Range points(weights, by.count);
  rows.for_each([&](int i) {
    float* from = slice_gradient + std::size_t(i) * kSliceWidth;
    float* row = gradient.row(std::size_t(brick) * kBrickRows + i);
    Four g = load<Four>(from);
    const Four scalars = load<Four>(from + kSliceScalars);
    if (layout.rigidity) row[layout.rigidity_column] += g[3];
    g[3] = 0;
    for (int c = 0; c < kScalars; ++c) {
      if (layout.scalar[c] == kBesidePlace && layout.displaces)
        g[kBesidePlace] = scalars[c];
      else if (layout.scalar[c] >= 0)
        for (int k = points.first; k < points.last; ++k)
          row[layout.stride * k + layout.scalar[c]] += weights[k] * scalars[c];
    }
    if (layout.displaces)
      for (int k = points.first; k < points.last; ++k)
        store(row + layout.stride * k, load<Four>(row + layout.stride * k) + weights[k] * g);
    std::fill_n(from, kSliceWidth, 0.0f);
  });
}

void centre_brick(const Contraction& by, const RowMask& rows, int brick, Channels& gradient) {
  const int stride = by.layout.stride, presence = by.layout.scalar[kPresence];
  if (presence < 0) return;
  rows.for_each([&](int i) {
    float* g = gradient.row(std::size_t(brick) * kBrickRows + i) + presence;
    float all = 0;
    for (int k = 0; k < by.count; ++k) all += g[stride * k];
    for (int k = 0; k < by.count; ++k) g[stride * k] -= by.mean[k] * all;
  });
}

double slope_brick(const Contraction& by, const Channels& level, const BasisWeights<float>& weights_dt,
                   const RowMask& rows, const float* slice_gradient, int brick) {
  const MotionLayout& layout = by.layout;
  const Range points(weights_dt, by.count);
  double sum = 0;
  rows.for_each([&](int i) {
    sum += row_slope(layout, level.row(std::size_t(brick) * kBrickRows + i), weights_dt, points.first,
                     points.last, slice_gradient + std::size_t(i) * kSliceWidth);
  });
  return sum;
}

MotionSlice make_slice(const MotionField& motion, const BasisWeights<float>& weights) {
  MotionSlice out;
  fill_slice(motion, weights, out);
  return out;
}

void fill_slice(const MotionField& motion, const BasisWeights<float>& weights, MotionSlice& out,
                std::span<const RowMask> rows) {
  if (motion.levels.empty()) {
    out = {};
    return;
  }
  const Channels& level = motion.levels.back();
  out.topology = level.topology;
  out.values.resize(level.topology->rows() * kSliceWidth);
  float* const values = out.values.data();
  const Contraction by(motion);
  for (int b = 0; b <= level.topology->brick_count(); ++b)
    contract_brick(by, level, {&weights, 1}, b, rows.empty() ? RowMask::all() : rows[b], {&values, 1});
}

MotionField collapse(const MotionField& motion) {
  if (motion.levels.size() < 2) return motion;
  MotionField out = motion;
  Channels sum = motion.levels.front();
  for (std::size_t l = 1; l < motion.levels.size(); ++l) {
    Channels fine = motion.levels[l];
    for (int b = 1; b <= fine.topology->brick_count(); ++b) prolong_brick(sum, fine, b, RowMask::all());
    sum = std::move(fine);
  }
  out.levels = {std::move(sum)};
  return out;
}

}  // namespace splinevox
