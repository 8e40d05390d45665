// SPDX-License-Identifier: Apache-2.0
#include "io/export/leaf_grid.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox {
namespace {

/// Whether 16-bit floats hold a grid: every value and, of densities, a hundredth of the largest with all
/// digits. In small units densities are large, in large ones small.
bool fits_half(const VdbGrid& grid) {
  constexpr float kLeastWithAllDigits = 6.1e-5f, kFaint = 1e-2f;
  float most = 0;
  for (const float v : grid.values) most = std::max(most, std::abs(v));
  const bool density = grid.name == "density";
  return most <= kLargestHalf && (!density || most == 0 || kFaint * most >= kLeastWithAllDigits);
}

}  // namespace

VdbGrid to_grid(LeafValues& values, int width, const std::string& name) {
  VdbGrid grid;
  grid.name = name;
  grid.width = width;
  grid.grid_class = VdbClass::fog_volume;
  for (const Int3& leaf : values.set().leaves()) grid.leaves.push_back(kBrick * leaf);
  for (const LeafMask& mask : values.set().masks())
    grid.active.insert(grid.active.end(), mask.begin(), mask.end());
  grid.values = std::move(values.values());
  return grid;
}

void place_grids(std::vector<VdbGrid>& grids, const Vec3d& origin, double spacing, bool half,
                 const ExportProfile& profile, std::map<std::string, double>& figures) {
  const bool asked = half && profile.stores_half();
  for (VdbGrid& grid : grids) {
    grid.spacing = spacing;
    grid.origin = origin;
    grid.half = asked && fits_half(grid);
    if (asked && !grid.half) figures["wider_than_half"] += 1;
  }
}

void shift_grids(std::vector<VdbGrid>& grids, const ExportProfile& profile) {
  for (VdbGrid& grid : grids)
    for (int a = 0; a < 3; ++a) grid.origin[a] += profile.shift * grid.spacing;
}

void add_box(std::map<std::string, double>& figures, const LeafSet& set, const Vec3d& origin,
             double spacing) {
  Int3 lo, hi;
  set.bounds(lo, hi);
  if (lo.x > hi.x) return;
  for (int a = 0; a < 3; ++a) {
    figures[std::string("min_") + "xyz"[a]] = origin[a] + spacing * lo[a];
    figures[std::string("max_") + "xyz"[a]] = origin[a] + spacing * hi[a];
  }
}

}  // namespace splinevox
