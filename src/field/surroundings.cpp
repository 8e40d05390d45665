// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "field/outer_walk.hpp"

namespace splinevox {

Lattice outer_lattice(int cells) { return make_lattice({{-2, -2, -2}, {2, 2, 2}}, cells); }

TopologyPtr outer_topology(int cells) {
  const Lattice lattice = outer_lattice(cells);
  std::vector<Int3> bricks;
  const auto all = make_dense_topology(lattice);
  for (int b = 1; b <= all->brick_count(); ++b) {
    const Vec3 lo = all->position(b, 0), hi = all->position(b, kBrickRows - 1);
    bool inside = true;  // the box itself, whose matter is elsewhere
    for (int a = 0; a < 3; ++a)
      inside = inside && std::max(std::abs(lo[a]), std::abs(hi[a])) < 1 - lattice.spacing;
    if (!inside) bricks.push_back(all->bricks[b]);
  }
  return make_topology(lattice, std::move(bricks));
}

// Not in the header, for the reason of Background::towards.
Vec3 VoxelModel::behind(const Ray& ray) const { return behind_box(background, surroundings, ray); }

Vec3 behind_box(const Background& background, const Surroundings& surroundings, const Ray& ray) {
  const Vec3 far = background.towards(cast<float>(ray.direction));
  return surroundings.any() ? OuterWalk(surroundings).forward(ray, far) : far;
}

}  // namespace splinevox
