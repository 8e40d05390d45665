// SPDX-License-Identifier: Apache-2.0
#include "view/reduce.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "math/logit.hpp"
#include "math/sh.hpp"
#include "math/view_factor.hpp"

namespace splinevox::run {

RadianceField halved(const RadianceField& field) {
  const Topology& fine = *field.raw.topology;
  Lattice lattice{fine.lattice.origin, 2 * fine.lattice.spacing, {}};
  for (int a = 0; a < 3; ++a) lattice.size[a] = std::max(2, fine.lattice.size[a] / 2 + 1);
  const auto lower = [](const Int3& a, const Int3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::set<Int3, decltype(lower)> bricks(lower);
  for (int b = 1; b <= fine.brick_count(); ++b) {
    // A fine brick reaches the coarse vertices from half its first vertex, rounded down, to half of what
    // follows its last.
    const Int3 first = kBrick * fine.bricks[b];
    Int3 c;
    for (c.x = first.x / 2 / kBrick; c.x <= std::min(first.x / 2 + 4, lattice.size.x - 1) / kBrick; ++c.x)
      for (c.y = first.y / 2 / kBrick; c.y <= std::min(first.y / 2 + 4, lattice.size.y - 1) / kBrick; ++c.y)
        for (c.z = first.z / 2 / kBrick; c.z <= std::min(first.z / 2 + 4, lattice.size.z - 1) / kBrick; ++c.z)
          bricks.insert(c);
  }
  RadianceField out = field;
  out.raw = make_channels(make_topology(lattice, {bricks.begin(), bricks.end()}), field.raw.width,
                          field.raw.row(0));
  const Topology& coarse = *out.raw.topology;
  const Int3 limit = kBrick * fine.dims, ring{kBrick, kBrick, kBrick};
  for (int b = 1; b <= coarse.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = out.raw.row(std::size_t(b) * kBrickRows + i);
      const Int3 centre = 2 * coarse.vertex(b, i) + ring;
      std::fill_n(row, out.raw.width, 0.0f);
      for (int n = 0; n < 27; ++n) {
        const Int3 d{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1}, v = centre + d;
        const bool inside = v.x < limit.x && v.y < limit.y && v.z < limit.z;
        const RingVertex at = ring_vertex(inside ? v : Int3{});
        const float* from =
            field.raw.row(std::size_t(fine.table[ring_slot(fine, at.brick)]) * kBrickRows + at.row);
        const float weight = (d.x ? 0.25f : 0.5f) * (d.y ? 0.25f : 0.5f) * (d.z ? 0.25f : 0.5f);
        for (int c = 0; c < out.raw.width; ++c) row[c] += weight * from[c];
      }
    }
  return out;
}

RadianceField without_view(const RadianceField& field) {
  if (field.sh_order < 0) return field;
  std::vector<std::array<float, kMaxShCount>> directions;
  for (int n = 0; n < 27; ++n) {
    const Vec3 d{float(n / 9 - 1), float(n / 3 % 3 - 1), float(n % 3 - 1)};
    if (d == Vec3{}) continue;
    sh_basis(field.sh_order, normalize(d), directions.emplace_back().data());
  }
  RadianceField out = field;
  out.sh_order = -1;
  for (std::size_t r = 0; r < out.raw.topology->rows(); ++r) {
    float* row = out.raw.row(r);
    float mean = 0;
    for (const auto& y : directions) {
      float q = 0;
      for (int j = 0; j < field.sh_count(); ++j) q += row[4 + j] * y[j];
      mean += view_factor(q).value / float(directions.size());
    }
    for (int c = 1; c < 4; ++c) {
      const float colour = std::clamp(mean * sigmoid(row[c]).value, 1e-4f, 1 - 1e-4f);
      row[c] = logit(colour);
    }
    std::fill(row + 4, row + out.raw.width, 0.0f);
  }
  return out;
}

}  // namespace splinevox::run
