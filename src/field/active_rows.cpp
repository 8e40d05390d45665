// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/active_rows.hpp"

#include <algorithm>

#include "splinevox/core/parallel.hpp"

namespace splinevox {

std::vector<RowMask> cells_of_rows(const Topology& topology, const std::vector<RowMask>& rows) {
  std::vector<RowMask> cells(topology.bricks.size());
  const auto find = [&](Int3 at, RowMask& found) {
    std::int32_t around[2][2][2];
    for (int c = 0; c < 8; ++c) around[c >> 2][c >> 1 & 1][c & 1] = topology.brick_at({at.x + (c >> 2), at.y + (c >> 1 & 1), at.z + (c & 1)});
    for (int i = 0; i < kBrickRows; ++i)
      for (int c = 0; c < 8; ++c) {
        const int x = (i >> 6) + (c >> 2), y = (i >> 3 & 7) + (c >> 1 & 1), z = (i & 7) + (c & 1);
        const std::int32_t b = around[x >> 3][y >> 3][z >> 3];
        if (b == 0 || !rows[b].test((x & 7) << 6 | (y & 7) << 3 | (z & 7))) continue;
        found.set(i);
        break;
      }
  };
  parallel_for(topology.brick_count(), [&](int index) { find(topology.bricks[index + 1], cells[index + 1]); });
  Int3 at;
  for (at.x = -1; at.x < topology.dims.x - 2; ++at.x)
    for (at.y = -1; at.y < topology.dims.y - 2; ++at.y)
      for (at.z = -1; at.z < topology.dims.z - 2; ++at.z)
        if (topology.brick_at(at) == 0) find(at, cells[0]);
  return cells;
}

ActiveRows nonzero_rows(const Channels& level) {
  ActiveRows out;
  out.rows.resize(level.topology->bricks.size());
  out.rows[0].set_all();
  parallel_for(level.topology->brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const float* row = level.row(std::size_t(index + 1) * kBrickRows + i);
      if (std::any_of(row, row + level.width, [](float v) { return v != 0; })) out.rows[index + 1].set(i);
    }
  });
  out.cells = cells_of_rows(*level.topology, out.rows);
  std::size_t awake = 0;
  for (std::size_t b = 1; b < out.cells.size(); ++b) out.cells[b].for_each([&](int) { ++awake; });
  const bool nothing = std::all_of(level.row(0), level.row(kBrickRows), [](float v) { return v == 0; });  // what absent bricks read
  if (!nothing || 2 * awake > level.topology->rows() - kBrickRows) out.cells.clear();
  return out;
}

}  // namespace splinevox
