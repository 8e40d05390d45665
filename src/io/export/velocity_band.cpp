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
  Int3 lo = from.leaves()[0], hi = lo;
  for (const Int3& leaf : from.leaves()) {
    lo = min(lo, leaf);
    hi = max(hi, leaf);
  }
  const Int3 margin{kMargin, kMargin, kMargin};
  LeafSet set(lo - margin, hi - lo + 2 * margin + Int3{1, 1, 1});
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
          if (layers > out.padding) asking[l][std::size_t(i >> 6)] |= std::uint64_t(1) << (i & 63);
        });
    const int layers = *std::max_element(most.begin(), most.end());
    if (layers <= out.padding) break;
    if (out.padding == kMaxPadding) {
      out.missing = layers - out.padding;
      break;
    }
    const LeafSet known = out.values.set(), next = last.with_masks(asking).grown(1);
    std::vector<LeafMask> fresh = next.masks();
    for (std::size_t l = 0; l < next.size(); ++l) {
      const Int3 leaf = next.leaves()[l];
      if (const std::int32_t k = known.find(leaf); k >= 0)
        for (std::size_t x = 0; x < kBrick; ++x) fresh[l][x] &= ~known.masks()[std::size_t(k)][x];
      if (fresh[l] != LeafMask{}) out.values.unite(leaf, fresh[l]);
    }
    last = next.with_masks(fresh);
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
