// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/levels.hpp"

#include "splinevox/core/simd.hpp"

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

/// Row of a vertex, 0 (the background brick) where it is absent. Vertices may lie outside the lattice by any amount.
std::size_t row_of(const Topology& t, Int3 v) {
  Int3 brick;
  for (int a = 0; a < 3; ++a) {
    brick[a] = v[a] >> 3;
    if (brick[a] < -1 || brick[a] > t.dims[a] - 2) return 0;
  }
  const std::int32_t b = t.brick_at(brick);
  return b == 0 ? 0 : std::size_t(b) * kBrickRows + ((v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
}

Int3 vertex(const Topology& t, int brick, int i) {
  const Int3 b = t.bricks[brick];
  return {b.x * kBrick + (i >> 6), b.y * kBrick + (i >> 3 & 7), b.z * kBrick + (i & 7)};
}

void add_row(const float* from, float weight, float* to, int width) {
  for (int k = 0; k < width; k += 8) store(to + k, load<Eight>(to + k) + weight * load<Eight>(from + k));
}

}  // namespace

void prolong_brick(const Channels& coarse, Channels& fine, int fine_brick) {
  for (int i = 0; i < kBrickRows; ++i) {
    const Int3 v = vertex(*fine.topology, fine_brick, i), odd{v.x & 1, v.y & 1, v.z & 1};
    const float weight = 1.0f / float(1 << (odd.x + odd.y + odd.z));
    float* to = fine.row(std::size_t(fine_brick) * kBrickRows + i);
    for (int x = 0; x <= odd.x; ++x)
      for (int y = 0; y <= odd.y; ++y)
        for (int z = 0; z <= odd.z; ++z)
          add_row(coarse.row(row_of(*coarse.topology, {(v.x >> 1) + x, (v.y >> 1) + y, (v.z >> 1) + z})), weight, to, fine.width);
  }
}

void restrict_brick(const Channels& fine, Channels& coarse, int coarse_brick) {
  for (int i = 0; i < kBrickRows; ++i) {
    const Int3 v = vertex(*coarse.topology, coarse_brick, i);
    float* to = coarse.row(std::size_t(coarse_brick) * kBrickRows + i);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const std::size_t from = row_of(*fine.topology, {2 * v.x + x, 2 * v.y + y, 2 * v.z + z});
          if (from) add_row(fine.row(from), 1.0f / float(1 << (x * x + y * y + z * z)), to, fine.width);
        }
  }
}

}  // namespace splinevox
