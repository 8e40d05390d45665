// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Voxels of one 8^3 leaf as bits: word x, bit 8 y + z. OpenVDB's own order.
using LeafMask = std::array<std::uint64_t, kBrick>;

/// Sets the bit of a voxel, numbered as rows of a brick are.
inline void add_voxel(LeafMask& mask, int voxel) {
  mask[std::size_t(voxel >> 6)] |= std::uint64_t(1) << (voxel & 63);
}

/// A sparse set of voxels: leaves of a bounded region, each with a mask. Leaf coordinate l holds voxels 8 l
/// .. 8 l + 7.
class LeafSet {
 public:
  LeafSet() = default;
  /// Empty, able to hold leaves lo <= l < lo + dims.
  LeafSet(Int3 lo, Int3 dims) : lo_(lo), dims_(dims), table_(std::size_t(dims.x) * dims.y * dims.z, -1) {}

  /// Adds a leaf. @pre inside the region, not there yet.
  void add(Int3 leaf, const LeafMask& mask) {
    table_[slot(leaf)] = std::int32_t(leaves_.size());
    leaves_.push_back(leaf);
    masks_.push_back(mask);
  }
  /// Adds voxels of a leaf, which may be there already. @pre inside the region
  void unite(Int3 leaf, const LeafMask& mask) {
    const std::int32_t l = find(leaf);
    if (l < 0) return add(leaf, mask);
    for (std::size_t x = 0; x < kBrick; ++x) masks_[std::size_t(l)][x] |= mask[x];
  }
  /// These leaves with other masks, [size()]; those without a voxel are left out.
  LeafSet with_masks(const std::vector<LeafMask>& masks) const {
    LeafSet out(lo_, dims_);
    for (std::size_t l = 0; l < size(); ++l)
      if (masks[l] != LeafMask{}) out.add(leaves_[l], masks[l]);
    return out;
  }
  /// These voxels but for those of another set.
  LeafSet without(const LeafSet& other) const;
  /// An empty set whose region reaches so many leaves further than these, to all sides. @pre size() > 0
  LeafSet around(int margin) const;
  /// Index of a leaf, or -1.
  std::int32_t find(Int3 leaf) const { return inside(leaf) ? table_[slot(leaf)] : -1; }
  bool active(Int3 voxel) const {
    const std::int32_t l = find({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3});
    return l >= 0 &&
           (masks_[std::size_t(l)][std::size_t(voxel.x & 7)] >> ((voxel.y & 7) * 8 + (voxel.z & 7)) & 1);
  }
  std::size_t size() const { return leaves_.size(); }
  const std::vector<Int3>& leaves() const { return leaves_; }
  const std::vector<LeafMask>& masks() const { return masks_; }
  std::uint64_t count() const;
  /// The smallest and the largest index of its voxels per axis; lo > hi where it has none.
  void bounds(Int3& lo, Int3& hi) const;

  /// The mask of `leaf` after every voxel has grown by one to all sides, edges and corners included.
  LeafMask grown_mask(Int3 leaf) const;
  /// This set grown `voxels` times. Leaves come in the order of their coordinates, x slowest; the region
  /// grows as needed.
  LeafSet grown(int voxels) const;

 private:
  bool inside(Int3 leaf) const {
    for (int a = 0; a < 3; ++a)
      if (leaf[a] < lo_[a] || leaf[a] >= lo_[a] + dims_[a]) return false;
    return true;
  }
  std::size_t slot(Int3 leaf) const {
    return (std::size_t(leaf.x - lo_.x) * std::size_t(dims_.y) + std::size_t(leaf.y - lo_.y)) *
               std::size_t(dims_.z) +
           std::size_t(leaf.z - lo_.z);
  }
  LeafSet grown_once() const;

  Int3 lo_{}, dims_{};
  std::vector<std::int32_t> table_;
  std::vector<Int3> leaves_;
  std::vector<LeafMask> masks_;
};

}  // namespace splinevox
