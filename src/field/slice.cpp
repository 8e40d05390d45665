// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/slice.hpp"

#include <algorithm>
#include <utility>

#include "splinevox/core/simd.hpp"

namespace splinevox {
namespace {

using Four = Simd<float>::Four;

BasisWeights<float> rounded(const MotionField& motion, const BasisWeights<double>& all) {
  const int first = motion.points - motion.stored_points();
  BasisWeights<float> w{};
  for (int k = first; k < motion.points; ++k) w[k - first] = float(all[k]);
  return w;
}

/// Calls visit(coarse row, weight, fine row) for every fine vertex and the one to eight coarse vertices around it.
template <class Visit>
void for_nested(const Topology& coarse, const Topology& fine, Visit&& visit) {
  const auto coarse_row = [&](Int3 v) -> std::size_t {
    const Int3 brick{v.x >> 3, v.y >> 3, v.z >> 3};
    for (int a = 0; a < 3; ++a)
      if (brick[a] > coarse.dims[a] - 2) return 0;  // past the ring: absent
    return std::size_t(coarse.brick_at(brick)) * kBrickRows + ((v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
  };
  for (int b = 1; b <= fine.brick_count(); ++b) {
    const Int3 base{fine.bricks[b].x * kBrick, fine.bricks[b].y * kBrick, fine.bricks[b].z * kBrick};
    for (int i = 0; i < kBrickRows; ++i) {
      const Int3 v{base.x + (i >> 6), base.y + (i >> 3 & 7), base.z + (i & 7)};
      const Int3 odd{v.x & 1, v.y & 1, v.z & 1};
      const float weight = 1.0f / float(1 << (odd.x + odd.y + odd.z));
      for (int x = 0; x <= odd.x; ++x)
        for (int y = 0; y <= odd.y; ++y)
          for (int z = 0; z <= odd.z; ++z)
            visit(coarse_row({(v.x >> 1) + x, (v.y >> 1) + y, (v.z >> 1) + z}), weight, std::size_t(b) * kBrickRows + i);
    }
  }
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

void expand_bricks(const MotionField& motion, const BasisWeights<float>* weights, const float* const* slice_gradients,
                   int frames, int first, int last, Channels& gradient) {
  const int stored = motion.stored_points(), rigidity = motion.rigidity_column();
  for (std::size_t r = std::size_t(first) * kBrickRows; r < std::size_t(last) * kBrickRows; ++r) {
    float* row = gradient.row(r);
    for (int f = 0; f < frames; ++f) {
      Four g = load<Four>(slice_gradients[f] + r * kSliceWidth);
      if (motion.rigidity) row[rigidity] += g[3];
      g[3] = 0;
      for (int k = 0; k < stored; ++k) store(row + 3 * k, load<Four>(row + 3 * k) + weights[f][k] * g);
    }
  }
}

void prolong_slice(const Topology& coarse, const float* coarse_values, const Topology& fine, float* out) {
  for_nested(coarse, fine, [&](std::size_t from, float weight, std::size_t to) {
    store(out + to * kSliceWidth, load<Four>(out + to * kSliceWidth) + weight * load<Four>(coarse_values + from * kSliceWidth));
  });
}

void restrict_gradient(const Topology& fine, const float* fine_gradient, const Topology& coarse, float* coarse_gradient) {
  for_nested(coarse, fine, [&](std::size_t to, float weight, std::size_t from) {
    if (to < std::size_t(kBrickRows)) return;  // the background brick is constant
    store(coarse_gradient + to * kSliceWidth,
          load<Four>(coarse_gradient + to * kSliceWidth) + weight * load<Four>(fine_gradient + from * kSliceWidth));
  });
}

void make_slice(const MotionField& motion, const BasisWeights<float>& weights, std::vector<AlignedVector<float>>& out) {
  out.resize(motion.levels.size());
  for (std::size_t l = 0; l < motion.levels.size(); ++l) {
    const Channels& level = motion.levels[l];
    out[l].resize(level.topology->rows() * kSliceWidth);
    contract_bricks(motion, level, weights, 0, level.topology->brick_count() + 1, out[l].data());
    if (l > 0) prolong_slice(*motion.levels[l - 1].topology, out[l - 1].data(), *level.topology, out[l].data());
  }
}

MotionSlice make_slice(const MotionField& motion, const BasisWeights<float>& weights) {
  if (motion.levels.empty()) return {};
  std::vector<AlignedVector<float>> slices;
  make_slice(motion, weights, slices);
  return {motion.levels.back().topology, std::move(slices.back())};
}

MotionField collapse(const MotionField& motion) {
  if (motion.levels.size() < 2) return motion;
  MotionField out = motion;
  Channels sum = motion.levels.front();
  for (std::size_t l = 1; l < motion.levels.size(); ++l) {
    Channels fine = motion.levels[l];
    for_nested(*sum.topology, *fine.topology, [&](std::size_t from, float weight, std::size_t to) {
      for (int c = 0; c < fine.width; ++c) fine.row(to)[c] += weight * sum.row(from)[c];
    });
    sum = std::move(fine);
  }
  out.levels = {std::move(sum)};
  return out;
}

}  // namespace splinevox
