// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <utility>

#include "core/parallel.hpp"
#include "field/lattice/row_mask.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

Channels make_channels(TopologyPtr topology, int width, const float* background) {
  Channels channels{std::move(topology), width, {}};
  const std::size_t rows = channels.topology->rows();
  channels.values.resize(rows * width);
  for (std::size_t r = 0; r < rows; ++r) std::memcpy(channels.row(r), background, sizeof(float) * width);
  return channels;
}

std::vector<std::int32_t> bricks_above(const Channels& channels, float raw) {
  const Topology& t = *channels.topology;
  std::vector<RowMask> above(t.bricks.size());
  parallel_for(t.brick_count(), [&](int index) {
    const int b = index + 1;
    for (int i = 0; i < kBrickRows; ++i)
      if (channels.row(std::size_t(b) * kBrickRows + i)[0] > raw) above[b].set(i);
  });
  std::vector<char> kept(t.bricks.size());
  for (int b = 1; b <= t.brick_count(); ++b)
    above[b].for_each([&](int i) {
      const Int3 v = t.vertex(b, i);
      Int3 next;  // of a vertex of its cells; what is outside the lattice is absent
      for (next.x = (v.x - 1) >> 3; next.x <= (v.x + 1) >> 3; ++next.x)
        for (next.y = (v.y - 1) >> 3; next.y <= (v.y + 1) >> 3; ++next.y)
          for (next.z = (v.z - 1) >> 3; next.z <= (v.z + 1) >> 3; ++next.z) kept[t.brick_at(next)] = 1;
    });
  std::vector<std::int32_t> bricks;
  for (int b = 1; b <= t.brick_count(); ++b)
    if (kept[b]) bricks.push_back(b);
  return bricks;
}

TopologyPtr keep_bricks(const Topology& topology, const std::vector<std::int32_t>& bricks) {
  std::vector<Int3> at;
  for (const std::int32_t b : bricks) at.push_back(topology.bricks[b]);
  return make_topology(topology.lattice, std::move(at));
}

void keep_rows(const std::vector<std::int32_t>& bricks, int width, AlignedVector<float>& rows) {
  const std::size_t size = std::size_t(kBrickRows) * width;
  for (std::size_t i = 0; i < bricks.size(); ++i)
    if (bricks[i] != std::int32_t(i + 1))
      std::memcpy(rows.data() + (i + 1) * size, rows.data() + bricks[i] * size, size * sizeof(float));
  rows.resize((bricks.size() + 1) * size);
}

}  // namespace splinevox
