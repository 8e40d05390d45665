// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "io/vdb/leaf_set.hpp"

namespace splinevox {

/// Values on the voxels of a LeafSet; 0 where nothing was written.
class LeafValues {
 public:
  LeafValues(LeafSet set, int width)
      : set_(std::move(set)), width_(width), values_(set_.size() * kBrickRows * std::size_t(width), 0.0f) {}

  const LeafSet& set() const { return set_; }
  std::vector<float>& values() { return values_; }
  float* at(std::size_t leaf, int voxel) {
    return values_.data() + (leaf * kBrickRows + std::size_t(voxel)) * std::size_t(width_);
  }
  /// Adds voxels, with the value 0. @pre their leaf is in the set's region
  void unite(Int3 leaf, const LeafMask& mask) {
    set_.unite(leaf, mask);
    values_.resize(set_.size() * kBrickRows * std::size_t(width_), 0.0f);
  }
  /// The value of a voxel whose leaf is in the set, or null.
  float* find(Int3 v) {
    const std::int32_t l = set_.find({v.x >> 3, v.y >> 3, v.z >> 3});
    return l < 0 ? nullptr : at(std::size_t(l), (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
  }

 private:
  LeafSet set_;
  int width_;
  std::vector<float> values_;
};

/// Calls visit(leaf number, voxel in leaf, voxel index) for every set bit, leaves in parallel. A visit may
/// write to its own voxel only.
template <class Masks, class Visit>
void for_each_voxel(const std::vector<Int3>& leaves, const Masks& masks, const Visit& visit) {
  parallel_for(int(leaves.size()), [&](int leaf) {
    const auto l = std::size_t(leaf);
    for (int x = 0; x < kBrick; ++x)
      for (std::uint64_t w = masks(l)[std::size_t(x)]; w != 0; w &= w - 1) {
        const int bit = std::countr_zero(w);
        visit(l, x << 6 | bit, kBrick * leaves[l] + Int3{x, bit >> 3, bit & 7});
      }
  });
}

/// Mean of the values at those of the 26 neighbours of `v` that are in `known`; 0 if there are none. `values`
/// must cover them.
inline Vec3 neighbour_mean(LeafValues& values, const LeafSet& known, Int3 v) {
  Vec3 sum{};
  int n = 0;
  for (int i = 0; i < 27; ++i) {
    const Int3 at = v + Int3{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
    if (!known.active(at)) continue;
    const float* p = values.find(at);
    sum += Vec3{p[0], p[1], p[2]};
    ++n;
  }
  return n == 0 ? sum : sum * (1.0f / float(n));
}

}  // namespace splinevox
