// SPDX-License-Identifier: Apache-2.0
#include "field/lattice/levels.hpp"

#include <algorithm>

#include "core/simd.hpp"

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

/// Brick number at a brick coordinate, 0 where it is absent or beyond the table.
std::int32_t brick_at(const Topology& t, Int3 brick) {
  for (int a = 0; a < 3; ++a)
    if (brick[a] < -1 || brick[a] > t.dims[a] - 2) return 0;
  return t.brick_at(brick);
}

std::size_t row_in(std::int32_t brick, int x, int y, int z) {
  return std::size_t(brick) * kBrickRows + ((x & 7) << 6 | (y & 7) << 3 | (z & 7));
}

void add_row(const float* from, float weight, float* to, int width) {
  for (int k = 0; k < width; k += 8) store(to + k, load<Eight>(to + k) + weight * load<Eight>(from + k));
}

}  // namespace

void prolong_brick(const Channels& coarse, Channels& fine, int fine_brick, const RowMask& rows) {
  // The fine brick's coarse vertices lie in one coarse brick, or in the next along an axis.
  const Int3 at = fine.topology->bricks[fine_brick], base{at.x >> 1, at.y >> 1, at.z >> 1};
  std::int32_t around[2][2][2];
  for (int i = 0; i < 8; ++i)
    around[i >> 2][i >> 1 & 1][i & 1] = brick_at(*coarse.topology, base + Int3{i >> 2, i >> 1 & 1, i & 1});
  rows.for_each([&](int i) {
    const Int3 v{(at.x & 1) * kBrick + (i >> 6), (at.y & 1) * kBrick + (i >> 3 & 7),
                 (at.z & 1) * kBrick + (i & 7)};
    const Int3 odd{v.x & 1, v.y & 1, v.z & 1};
    const float weight = 1.0f / float(1 << (odd.x + odd.y + odd.z));
    float* to = fine.row(std::size_t(fine_brick) * kBrickRows + i);
    for (int x = v.x >> 1; x <= (v.x + 1) >> 1; ++x)
      for (int y = v.y >> 1; y <= (v.y + 1) >> 1; ++y)
        for (int z = v.z >> 1; z <= (v.z + 1) >> 1; ++z)
          add_row(coarse.row(row_in(around[x >> 3][y >> 3][z >> 3], x, y, z)), weight, to, fine.width);
  });
}

void restrict_brick(const Channels& fine, const std::vector<RowMask>& fine_rows, Channels& coarse,
                    int coarse_brick, RowMask& touched) {
  const Int3 first = 2 * coarse.topology->bricks[coarse_brick];
  Int3 d;  // fine bricks relative to the first of the eight inside; those below reach in with their last
           // layer of rows
  for (d.x = -1; d.x <= 1; ++d.x)
    for (d.y = -1; d.y <= 1; ++d.y)
      for (d.z = -1; d.z <= 1; ++d.z) {
        const std::int32_t brick = brick_at(*fine.topology, first + d);
        if (brick == 0) continue;
        fine_rows[brick].for_each([&](int i) {
          const Int3 v{d.x * kBrick + (i >> 6), d.y * kBrick + (i >> 3 & 7), d.z * kBrick + (i & 7)};
          Int3 lo, hi;  // its coarse vertices inside the brick
          for (int a = 0; a < 3; ++a) {
            lo[a] = std::max(v[a] >> 1, 0);
            hi[a] = std::min((v[a] + 1) >> 1, kBrick - 1);
          }
          const float weight = 1.0f / float(1 << ((v.x & 1) + (v.y & 1) + (v.z & 1)));
          const float* from = fine.row(std::size_t(brick) * kBrickRows + i);
          for (int x = lo.x; x <= hi.x; ++x)
            for (int y = lo.y; y <= hi.y; ++y)
              for (int z = lo.z; z <= hi.z; ++z) {
                touched.set(x * 64 + y * 8 + z);
                add_row(from, weight, coarse.row(row_in(coarse_brick, x, y, z)), fine.width);
              }
        });
      }
}

}  // namespace splinevox
