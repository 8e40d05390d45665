// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "splinevox/field/lattice.hpp"

namespace splinevox {

Lattice make_lattice(const Box& box, int cells) {
  const Vec3 extent = box.extent();
  const float longest = std::max({extent.x, extent.y, extent.z});
  Lattice lattice{box.lo, std::max(longest / float(cells), kLeastSpacing), {}};
  // The tolerance keeps an edge that is a whole number of cells from gaining one by rounding.
  for (int a = 0; a < 3; ++a)
    lattice.size[a] = std::max(1, int(std::ceil(extent[a] / lattice.spacing - 1e-3f))) + 1;
  return lattice;
}

TopologyPtr make_topology(const Lattice& lattice, std::vector<Int3> bricks) {
  std::sort(bricks.begin(), bricks.end(), [](const Int3& a, const Int3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  });
  auto topology = std::make_shared<Topology>();
  topology->lattice = lattice;
  for (int a = 0; a < 3; ++a) topology->dims[a] = (lattice.size[a] + kBrick - 1) / kBrick + 2;
  topology->table.assign(std::size_t(topology->dims.x) * topology->dims.y * topology->dims.z, 0);
  topology->bricks.reserve(bricks.size() + 1);
  topology->bricks.push_back({});
  for (const Int3& brick : bricks) {
    topology->table[topology->slot(brick)] = std::int32_t(topology->bricks.size());
    topology->bricks.push_back(brick);
  }
  return topology;
}

TopologyPtr make_dense_topology(const Lattice& lattice) {
  std::vector<Int3> bricks;
  for (int x = 0; x * kBrick < lattice.size.x; ++x)
    for (int y = 0; y * kBrick < lattice.size.y; ++y)
      for (int z = 0; z * kBrick < lattice.size.z; ++z) bricks.push_back({x, y, z});
  return make_topology(lattice, std::move(bricks));
}

}  // namespace splinevox
