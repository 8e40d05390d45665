// SPDX-License-Identifier: Apache-2.0
#include "field/matter_reach.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "math/activation.hpp"
#include "math/rigidity.hpp"

namespace splinevox {
namespace {

struct Range {
  float lo = INFINITY, hi = -INFINITY;
  void add(float v) {
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
};

/// Vertices around [lo, hi] along one axis, as indices of a lattice; everything outside reads the background,
/// so one vertex beyond either end stands for all.
void vertex_range(const Lattice& lattice, int axis, float lo, float hi, int bricks, int& first, int& last) {
  const float scale = 1 / lattice.spacing, limit = float(bricks * kBrick);
  const auto coordinate = [&](float x) {
    return std::clamp((x - lattice.origin[axis]) * scale, -1.0f, limit);
  };
  first = int(std::floor(coordinate(lo) - 1e-3f));
  last = int(std::floor(coordinate(hi) + 1e-3f)) + 1;
  first = std::max(first, -1);
  last = std::min(last, bricks * kBrick);
}

/// Where Delta can lead from inside a box: the ranges of its three components.
/// @return the largest presence there
float displacement_ranges(const MotionField& motion, const MotionSlice& slice, Vec3 lo, Vec3 hi,
                          Range (&out)[3]) {
  const Topology& t = *slice.topology;
  int first[3], last[3];
  for (int a = 0; a < 3; ++a) vertex_range(t.lattice, a, lo[a], hi[a], t.dims[a] - 2, first[a], last[a]);
  Range base[3], raw, presence;
  for (int x = first[0]; x <= last[0]; ++x)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int z = first[2]; z <= last[2]; ++z) {
        const std::int32_t brick = t.brick_at({x >> 3, y >> 3, z >> 3});
        const std::size_t row =
            std::size_t(brick) * kBrickRows + std::size_t((x & 7) << 6 | (y & 7) << 3 | (z & 7));
        const float* v = slice.values.data() + row * kSliceWidth;
        for (int a = 0; a < 3; ++a) base[a].add(v[a]);
        raw.add(v[3]);
        presence.add(v[kSliceScalars + kPresence]);
      }
  float r_lo = 1, r_hi = 1;
  if (motion.rigidity) {
    r_lo = rigidity_of(raw.lo, motion.rigidity_offset).value;
    r_hi = rigidity_of(raw.hi, motion.rigidity_offset).value;
  }
  for (int a = 0; a < 3; ++a) {
    out[a] = {std::min(r_lo * base[a].lo, r_hi * base[a].lo), std::max(r_lo * base[a].hi, r_hi * base[a].hi)};
    const float slack = 1e-4f * (std::abs(out[a].lo) + std::abs(out[a].hi));
    out[a].lo -= slack;
    out[a].hi += slack;
  }
  return presence.hi;
}

}  // namespace

MatterReach::MatterReach(const VoxelModel& model, float min_density) : model_(model) {
  const RadianceField& field = model.radiance;
  const Topology& t = *field.raw.topology;
  bricks_ = t.dims - Int3{2, 2, 2};
  // softplus is monotone, and trilinear interpolation stays within its corners: a brick matters if one raw
  // value does, with the presence of the place that looks it up.
  raw_min_ = float(raw_of_depth(min_density, field.activation.scale, field.activation.shift)) - 1e-3f;
  peaks_.assign(std::size_t(t.brick_count()) + 1, field.raw.row(0)[0]);
  parallel_for(t.brick_count() + 1, [&](int b) {
    for (std::size_t r = std::size_t(b) * kBrickRows; r < std::size_t(b + 1) * kBrickRows; ++r)
      peaks_[std::size_t(b)] = std::max(peaks_[std::size_t(b)], field.raw.row(r)[0]);
  });
  peaks_[0] = -INFINITY;  // what is absent shows nothing, whatever the background is
  const Int3 n = bricks_ + Int3{1, 1, 1};
  sums_.assign(std::size_t(n.x) * n.y * n.z, 0);
  const auto at = [&](int x, int y, int z) -> std::int32_t& {
    return sums_[(std::size_t(x) * n.y + y) * n.z + z];
  };
  for (int x = 1; x < n.x; ++x)
    for (int y = 1; y < n.y; ++y)
      for (int z = 1; z < n.z; ++z)
        at(x, y, z) = (peak({x - 1, y - 1, z - 1}) >= raw_min_) + at(x - 1, y, z) + at(x, y - 1, z) +
                      at(x, y, z - 1) - at(x - 1, y - 1, z) - at(x - 1, y, z - 1) - at(x, y - 1, z - 1) +
                      at(x - 1, y - 1, z - 1);
}

float MatterReach::peak(Int3 brick) const {
  return peaks_[std::size_t(model_.radiance.raw.topology->brick_at(brick))];
}

bool MatterReach::occupied(Vec3 lo, Vec3 hi, float presence) const {
  const Lattice& lattice = model_.radiance.raw.topology->lattice;
  Int3 first, last;
  for (int a = 0; a < 3; ++a) {
    vertex_range(lattice, a, lo[a], hi[a], bricks_[a], first[a], last[a]);
    first[a] = std::max(first[a], 0) >> 3;
    last[a] = std::min(last[a] >> 3, bricks_[a] - 1) + 1;
    if (first[a] >= last[a]) return false;
  }
  if (presence != 0) {  // the sums are of bricks that matter without
    Int3 b;
    for (b.x = first.x; b.x < last.x; ++b.x)
      for (b.y = first.y; b.y < last.y; ++b.y)
        for (b.z = first.z; b.z < last.z; ++b.z)
          if (peak(b) + presence >= raw_min_) return true;
    return false;
  }
  const Int3 n = bricks_ + Int3{1, 1, 1};
  const auto at = [&](int x, int y, int z) { return sums_[(std::size_t(x) * n.y + y) * n.z + z]; };
  const auto slab = [&](int x) {
    return at(x, last[1], last[2]) - at(x, first[1], last[2]) - at(x, last[1], first[2]) +
           at(x, first[1], first[2]);
  };
  return slab(last[0]) - slab(first[0]) > 0;
}

std::vector<Int3> MatterReach::candidates(const Lattice& out, const BasisWeights<float>& weights) const {
  const MotionField& motion = model_.motion;
  MotionSlice slice;
  if (!motion.levels.empty()) slice = make_slice(motion, weights);
  Int3 leaves{};
  for (int a = 0; a < 3; ++a) leaves[a] = (out.size[a] + kBrick - 1) / kBrick;
  std::vector<std::vector<Int3>> found(std::size_t(leaves.x));
  parallel_for(leaves.x, [&](int x) {
    for (int y = 0; y < leaves.y; ++y)
      for (int z = 0; z < leaves.z; ++z) {
        const Int3 leaf{x, y, z};
        const Vec3 lo = out.position(kBrick * leaf), hi = out.position(kBrick * leaf + Int3{7, 7, 7});
        Range moved[3] = {{0, 0}, {0, 0}, {0, 0}};
        const float presence = slice.topology ? displacement_ranges(motion, slice, lo, hi, moved) : 0;
        if (occupied(lo + Vec3{moved[0].lo, moved[1].lo, moved[2].lo},
                     hi + Vec3{moved[0].hi, moved[1].hi, moved[2].hi}, presence))
          found[std::size_t(x)].push_back(leaf);
      }
  });
  std::vector<Int3> all;
  for (const auto& slab : found) all.insert(all.end(), slab.begin(), slab.end());
  return all;
}

}  // namespace splinevox
