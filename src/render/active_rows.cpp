// SPDX-License-Identifier: Apache-2.0
#include "render/active_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"

namespace splinevox {

float reach_of_vertex(const Lattice& lattice) {
  const Vec3 lo = lattice.origin, hi = lattice.position(lattice.size - Int3{1, 1, 1});
  const float farthest = std::max(
      {std::abs(lo.x), std::abs(lo.y), std::abs(lo.z), std::abs(hi.x), std::abs(hi.y), std::abs(hi.z)});
  // A little more than one spacing: rays find cells and vertices by other roundings.
  return 1.01f * lattice.spacing + 4 * std::numeric_limits<float>::epsilon() * farthest;
}

float extent_of_vertex(const Lattice& lattice) { return (1 - 1e-4f) * lattice.spacing; }

BitGrid reach_of(const Topology& topology, const std::vector<RowMask>& rows, const BitGrid& like) {
  BitGrid out = like;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  const float reach = extent_of_vertex(topology.lattice);
  const Vec3 around{reach, reach, reach};
  for (int b = 1; b <= topology.brick_count(); ++b)
    rows[b].for_each([&](int i) {
      const Vec3 x = topology.position(b, i);
      const Int3 first = out.cell_of(x - around), last = out.cell_of(x + around);
      Int3 c;
      for (c.x = first.x; c.x <= last.x; ++c.x)
        for (c.y = first.y; c.y <= last.y; ++c.y)
          for (c.z = first.z; c.z <= last.z; ++c.z) out.set(out.index(c));
    });
  return out;
}

std::vector<RowMask> nonzero_rows(const Channels& level) {
  std::vector<RowMask> out(level.topology->bricks.size());
  parallel_for(int(out.size()), [&](int b) {
    for (int i = 0; i < kBrickRows; ++i) {
      const float* row = level.row(std::size_t(b) * kBrickRows + i);
      if (std::any_of(row, row + level.width, [](float v) { return v != 0; })) out[b].set(i);
    }
  });
  return out;
}

}  // namespace splinevox
