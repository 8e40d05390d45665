// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/slice.hpp"

#include <algorithm>
#include <utility>

#include "splinevox/core/simd.hpp"
#include "splinevox/field/levels.hpp"

namespace splinevox {
namespace {

using Four = Simd<float>::Four;

BasisWeights<float> rounded(const MotionField& motion, const BasisWeights<double>& all) {
  const int first = motion.points - motion.stored_points();
  BasisWeights<float> w{};
  for (int k = first; k < motion.points; ++k) w[k - first] = float(all[k]);
  return w;
}

}  // namespace

BasisWeights<float> stored_weights(const MotionField& motion, double t) {
  t = std::clamp(t, 0.0, 1.0);
  return rounded(motion, motion.basis == BasisKind::bezier ? bernstein_weights(motion.points, t)
                                                           : bspline_weights(motion.points, t));
}

BasisWeights<float> stored_weights_dt(const MotionField& motion, double t) {
  t = std::clamp(t, 0.0, 1.0);
  return rounded(motion, motion.basis == BasisKind::bezier ? bernstein_weights_dt(motion.points, t)
                                                           : bspline_weights_dt(motion.points, t));
}

void contract_bricks(const MotionField& motion, const Channels& level, const BasisWeights<float>& weights, int first,
                     int last, float* out) {
  const int stored = motion.stored_points(), rigidity = motion.rigidity_column();
  for (std::size_t r = std::size_t(first) * kBrickRows; r < std::size_t(last) * kBrickRows; ++r) {
    const float* row = level.row(r);
    Four sum{};
    // The fourth lane reads the next point's x (or the rigidity) and is replaced below.
    for (int k = 0; k < stored; ++k) sum += weights[k] * load<Four>(row + 3 * k);
    sum[3] = motion.rigidity ? row[rigidity] : 0.0f;
    store(out + r * kSliceWidth, sum);
  }
}

void expand_brick(const MotionField& motion, const BasisWeights<float>* weights, const float* const* slice_gradients,
                  int frames, int brick, Channels& gradient, RowMask& touched) {
  const int stored = motion.stored_points(), rigidity = motion.rigidity_column();
  for (int i = 0; i < kBrickRows; ++i) {
    const std::size_t r = std::size_t(brick) * kBrickRows + i;
    float* row = gradient.row(r);
    for (int f = 0; f < frames; ++f) {
      Four g = load<Four>(slice_gradients[f] + r * kSliceWidth);
      if (g[0] == 0 && g[1] == 0 && g[2] == 0 && g[3] == 0) continue;
      touched.set(i);
      if (motion.rigidity) row[rigidity] += g[3];
      g[3] = 0;
      for (int k = 0; k < stored; ++k) store(row + 3 * k, load<Four>(row + 3 * k) + weights[f][k] * g);
    }
  }
}

MotionSlice make_slice(const MotionField& motion, const BasisWeights<float>& weights) {
  if (motion.levels.empty()) return {};
  const Channels& level = motion.levels.back();
  MotionSlice out{level.topology, {}};
  out.values.resize(level.topology->rows() * kSliceWidth);
  contract_bricks(motion, level, weights, 0, level.topology->brick_count() + 1, out.values.data());
  return out;
}

MotionField collapse(const MotionField& motion) {
  if (motion.levels.size() < 2) return motion;
  MotionField out = motion;
  Channels sum = motion.levels.front();
  for (std::size_t l = 1; l < motion.levels.size(); ++l) {
    Channels fine = motion.levels[l];
    for (int b = 1; b <= fine.topology->brick_count(); ++b) prolong_brick(sum, fine, b);
    sum = std::move(fine);
  }
  out.levels = {std::move(sum)};
  return out;
}

}  // namespace splinevox
