// SPDX-License-Identifier: Apache-2.0
#include "io/export/velocity_band.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox {
namespace {

constexpr int kMaxPadding = 64;  ///< voxels: memory has an end

/// The same voxels in a region that has room for all layers.
LeafValues with_room(LeafValues core) {
  constexpr int kMargin = kMaxPadding / kBrick + 1;
  const LeafSet& from = core.set();
  LeafSet set = from.around(kMargin);
  for (std::size_t l = 0; l < from.size(); ++l) set.add(from.leaves()[l], from.masks()[l]);
  LeafValues out(std::move(set), 3);
  out.values() = std::move(core.values());
  return out;
}

}  // namespace

VelocityBand spread_velocity(LeafValues core, double voxels_per_speed) {
  if (core.set().size() == 0) return {std::move(core)};
  VelocityBand out{with_room(std::move(core))};
  LeafSet last = out.values.set();  // the voxels of the last layer
  for (;; ++out.padding) {
    std::vector<LeafMask> asking(last.size(), LeafMask{});
    std::vector<int> most(last.size(), 0);
    for_each_voxel(
        last.leaves(), [&](std::size_t l) -> const LeafMask& { return last.masks()[l]; },
        [&](std::size_t l, int i, Int3 v) {
          const float* p = out.values.find(v);
          const double far = std::ceil(length(Vec3d{p[0], p[1], p[2]}) * voxels_per_speed);
          const int layers = int(std::min(1e6, far)) + 1;
          most[l] = std::max(most[l], layers);
          if (layers > out.padding) add_voxel(asking[l], i);
        });
    const int layers = *std::max_element(most.begin(), most.end());
    if (layers <= out.padding) break;
    if (out.padding == kMaxPadding) {
      out.missing = layers - out.padding;
      break;
    }
    const LeafSet known = out.values.set();
    last = last.with_masks(asking).grown(1).without(known);
    for (std::size_t l = 0; l < last.size(); ++l) out.values.unite(last.leaves()[l], last.masks()[l]);
    for_each_voxel(
        last.leaves(), [&](std::size_t l) -> const LeafMask& { return last.masks()[l]; },
        [&](std::size_t, int, Int3 v) {
          const Vec3 mean = neighbour_mean(out.values, known, v);
          float* p = out.values.find(v);
          for (int a = 0; a < 3; ++a) p[a] = mean[a];
        });
    if (last.size() == 0) break;
  }
  return out;
}

}  // namespace splinevox
