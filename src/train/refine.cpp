// SPDX-License-Identifier: Apache-2.0
#include "train/refine.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "field/lattice/locate.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

bool prune_empty(Channels& raw, std::initializer_list<AlignedVector<float>*> beside) {
  constexpr float kRounding = 1e-3f;  // of what has been resampled
  const std::vector<std::int32_t> kept = bricks_above(raw, kEmptyDensity + kRounding);
  if (kept.empty() || int(kept.size()) == raw.topology->brick_count()) return false;
  keep_rows(kept, raw.width, raw.values);
  for (AlignedVector<float>* rows : beside) keep_rows(kept, raw.width, *rows);
  raw.topology = keep_bricks(*raw.topology, kept);
  return true;
}

TopologyPtr bricks_near(const Lattice& lattice, const BitGrid& cells) {
  std::vector<Int3> bricks;
  Int3 b;
  for (b.x = 0; b.x * kBrick < lattice.size.x; ++b.x)
    for (b.y = 0; b.y * kBrick < lattice.size.y; ++b.y)
      for (b.z = 0; b.z * kBrick < lattice.size.z; ++b.z) {
        const Int3 first{b.x * kBrick - 1, b.y * kBrick - 1, b.z * kBrick - 1};
        if (cells.any(lattice.position(first), lattice.position(first + Int3{9, 9, 9}))) bricks.push_back(b);
      }
  return make_topology(lattice, std::move(bricks));
}

std::vector<RowMask> rows_near(const Topology& topology, const BitGrid& cells, float reach) {
  std::vector<RowMask> rows(topology.bricks.size());
  const Vec3 around{reach, reach, reach};
  parallel_for(topology.brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = topology.position(index + 1, i);
      if (cells.any(x - around, x + around)) rows[index + 1].set(i);
    }
  });
  return rows;
}

Channels resample(const Channels& from, TopologyPtr topology, const std::function<Vec3(Vec3)>& moved) {
  using Eight = Simd<float>::Eight;
  Channels out = make_channels(std::move(topology), from.width, from.row(0));
  const BrickView<float> view(*from.topology);
  const Topology& to = *out.topology;
  parallel_for(to.brick_count(), [&](int index) {
    const int b = index + 1;
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = to.position(b, i);
      const Located at = locate(view, moved ? moved(x) : x);
      float* row = out.row(std::size_t(b) * kBrickRows + i);
      for (int k = 0; k < out.width; k += 8)
        store(row + k, interpolate<Eight>(at, from.values.data(), out.width, k));
    }
  });
  return out;
}

void elevate(MotionField& motion) {
  const Refinement& refinement = basis_of(motion.basis).refinement;
  MotionField next = motion;
  next.points = refinement.refined(motion.points);
  const int width = next.width(), pinned = motion.points - motion.stored_points();
  const int stride = motion.stride(), rigidity = motion.rigidity_column();
  const int next_rigidity = next.rigidity_column();
  std::vector<float> in(motion.points, 0.0f), out(next.points);
  for (Channels& level : next.levels) {
    const Channels old = std::move(level);
    const std::vector<float> zero(width, 0.0f);
    level = make_channels(old.topology, width, zero.data());
    for (std::size_t r = 0; r < old.topology->rows(); ++r) {
      for (int a = 0; a < stride; ++a) {
        for (int k = pinned; k < motion.points; ++k) in[k] = old.row(r)[stride * (k - pinned) + a];
        refinement(motion.points, in.data(), out.data());
        for (int k = pinned; k < next.points; ++k) level.row(r)[stride * (k - pinned) + a] = out[k];
      }
      level.row(r)[next_rigidity] = old.row(r)[rigidity];
    }
  }
  motion = std::move(next);
}

}  // namespace splinevox
