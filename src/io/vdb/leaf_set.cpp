// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/leaf_set.hpp"

#include <algorithm>
#include <bit>
#include <climits>

namespace splinevox {
namespace {

constexpr std::uint64_t kFirstZ = 0x0101010101010101ull, kLastZ = kFirstZ << 7;

/// One x-plane of 8 x 8 voxels grown along z; before and after are the planes of the neighbours in z.
std::uint64_t grow_z(std::uint64_t w, std::uint64_t before, std::uint64_t after) {
  return w | ((w & ~kLastZ) << 1) | ((w & ~kFirstZ) >> 1) | ((before & kLastZ) >> 7) |
         ((after & kFirstZ) << 7);
}

std::uint64_t grow_y(std::uint64_t w, std::uint64_t before, std::uint64_t after) {
  return w | w << 8 | w >> 8 | before >> 56 | after << 56;
}

}  // namespace

std::uint64_t LeafSet::count() const {
  std::uint64_t n = 0;
  for (const LeafMask& mask : masks_)
    for (const std::uint64_t w : mask) n += std::uint64_t(std::popcount(w));
  return n;
}

void LeafSet::bounds(Int3& lo, Int3& hi) const {
  lo = {INT_MAX, INT_MAX, INT_MAX};
  hi = {INT_MIN, INT_MIN, INT_MIN};
  for (std::size_t l = 0; l < size(); ++l)
    for (int x = 0; x < kBrick; ++x)
      for (std::uint64_t w = masks_[l][std::size_t(x)]; w != 0; w &= w - 1) {
        const int bit = std::countr_zero(w);
        const Int3 v = kBrick * leaves_[l] + Int3{x, bit >> 3, bit & 7};
        for (int a = 0; a < 3; ++a) {
          lo[a] = std::min(lo[a], v[a]);
          hi[a] = std::max(hi[a], v[a]);
        }
      }
}

LeafMask LeafSet::grown_mask(Int3 leaf) const {
  static constexpr LeafMask kNone{};
  // planes[x + 1]: x-plane x of this leaf (-1 and 8 belong to the neighbours in x), grown along y and z.
  std::uint64_t planes[kBrick + 2] = {};
  for (int dx = -1; dx <= 1; ++dx) {
    const LeafMask* around[3][3];
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz) {
        const std::int32_t l = find(leaf + Int3{dx, dy, dz});
        around[dy + 1][dz + 1] = l < 0 ? &kNone : &masks_[std::size_t(l)];
      }
    const int begin = dx < 0 ? kBrick - 1 : 0, end = dx > 0 ? 1 : kBrick;
    for (int x = begin; x < end; ++x) {
      std::uint64_t rows[3];
      for (int y = 0; y < 3; ++y)
        rows[y] = grow_z((*around[y][1])[std::size_t(x)], (*around[y][0])[std::size_t(x)],
                         (*around[y][2])[std::size_t(x)]);
      planes[dx * kBrick + x + 1] = grow_y(rows[1], rows[0], rows[2]);
    }
  }
  LeafMask out;
  for (std::size_t x = 0; x < kBrick; ++x) out[x] = planes[x] | planes[x + 1] | planes[x + 2];
  return out;
}

LeafSet LeafSet::without(const LeafSet& other) const {
  std::vector<LeafMask> masks = masks_;
  for (std::size_t l = 0; l < size(); ++l)
    if (const std::int32_t o = other.find(leaves_[l]); o >= 0)
      for (std::size_t x = 0; x < kBrick; ++x) masks[l][x] &= ~other.masks_[std::size_t(o)][x];
  return with_masks(masks);
}

LeafSet LeafSet::around(int margin) const {
  Int3 lo = leaves_[0], hi = lo;
  for (const Int3& leaf : leaves_) {
    lo = min(lo, leaf);
    hi = max(hi, leaf);
  }
  const Int3 by{margin, margin, margin};
  return {lo - by, hi - lo + 2 * by + Int3{1, 1, 1}};
}

LeafSet LeafSet::grown_once() const {
  if (leaves_.empty()) return *this;
  LeafSet out = around(1);
  std::vector<char> near(out.table_.size(), 0);
  for (const Int3& leaf : leaves_)
    for (int i = 0; i < 27; ++i) near[out.slot(leaf + Int3{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1})] = 1;
  std::size_t s = 0;
  for (int x = 0; x < out.dims_.x; ++x)
    for (int y = 0; y < out.dims_.y; ++y)
      for (int z = 0; z < out.dims_.z; ++z, ++s) {
        if (!near[s]) continue;
        const Int3 leaf = out.lo_ + Int3{x, y, z};
        const LeafMask mask = grown_mask(leaf);
        if (mask != LeafMask{}) out.add(leaf, mask);
      }
  return out;
}

LeafSet LeafSet::grown(int voxels) const {
  LeafSet out = *this;
  for (int i = 0; i < voxels; ++i) out = out.grown_once();
  return out;
}

}  // namespace splinevox
