// SPDX-License-Identifier: Apache-2.0
#include "splinevox/render/occupancy.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "splinevox/field/locate.hpp"
#include "splinevox/math/activation.hpp"

namespace splinevox {
namespace {

/// ORs each cell with its two neighbours along one axis.
BitGrid dilate_axis(const BitGrid& in, int axis) {
  BitGrid out = in;
  const std::size_t stride = axis == 0 ? std::size_t(in.size.y) * in.size.z : axis == 1 ? std::size_t(in.size.z) : 1;
  Int3 c;
  for (c.x = 0; c.x < in.size.x; ++c.x)
    for (c.y = 0; c.y < in.size.y; ++c.y)
      for (c.z = 0; c.z < in.size.z; ++c.z) {
        const std::size_t i = in.index(c);
        if (!in.test(i)) continue;
        if (c[axis] > 0) out.set(i - stride);
        if (c[axis] + 1 < in.size[axis]) out.set(i + stride);
      }
  return out;
}

/// Blocks of n cells an edge with any cell set.
BitGrid coarsen(const BitGrid& in, int n) {
  BitGrid out;
  out.origin = in.origin, out.cell = in.cell * float(n);
  for (int a = 0; a < 3; ++a) out.size[a] = (in.size[a] + n - 1) / n;
  out.bits.assign((out.cells() + 31) / 32, 0);
  Int3 c;
  for (c.x = 0; c.x < in.size.x; ++c.x)
    for (c.y = 0; c.y < in.size.y; ++c.y)
      for (c.z = 0; c.z < in.size.z; ++c.z)
        if (in.test(in.index(c))) out.set(out.index({c.x / n, c.y / n, c.z / n}));
  return out;
}

/// x + Delta(x) from a slice.
class WarpedLookup {
 public:
  WarpedLookup(const VoxelModel& model, const MotionSlice& slice)
      : view_(*slice.topology), values_(slice.values.data()), rigidity_(model.motion.rigidity), offset_(model.motion.rigidity_offset) {}

  Vec3 operator()(const Vec3& x) const {
    const auto m = interpolate<Simd<float>::Four>(locate(view_, x), values_, kSliceWidth, 0);
    const float r = rigidity_ ? sigmoid(m[3] + offset_).value : 1.0f;
    return x + r * Vec3{m[0], m[1], m[2]};
  }

 private:
  BrickView<float> view_;
  const float* values_;
  bool rigidity_;
  float offset_;
};

}  // namespace

BitGrid::BitGrid(const Box& box, int cells_along_longest) : origin(box.lo) {
  const Vec3 extent = box.extent();
  cell = std::max({extent.x, extent.y, extent.z}) / float(cells_along_longest);
  for (int a = 0; a < 3; ++a) size[a] = std::max(1, int(std::ceil(extent[a] / cell - 1e-3f)));
  bits.assign((cells() + 31) / 32, 0);
}


std::size_t BitGrid::count() const {
  std::size_t n = 0;
  for (const std::uint32_t word : bits) n += std::popcount(word);
  return n;
}

BitGrid dilate(const BitGrid& grid) { return dilate_axis(dilate_axis(dilate_axis(grid, 0), 1), 2); }

BitGrid drop_small_parts(const BitGrid& grid, float share) {
  BitGrid left = grid, out = grid;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  const double needed = double(share) * double(grid.count());
  std::vector<Int3> part;
  Int3 seed;
  for (seed.x = 0; seed.x < grid.size.x; ++seed.x)
    for (seed.y = 0; seed.y < grid.size.y; ++seed.y)
      for (seed.z = 0; seed.z < grid.size.z; ++seed.z) {
        if (!left.test(left.index(seed))) continue;
        part.assign(1, seed);
        left.clear(left.index(seed));
        for (std::size_t next = 0; next < part.size(); ++next) {
          const Int3 at = part[next], lo = max(at - Int3{1, 1, 1}, Int3{0, 0, 0}), hi = min(at + Int3{2, 2, 2}, grid.size);
          Int3 c;
          for (c.x = lo.x; c.x < hi.x; ++c.x)
            for (c.y = lo.y; c.y < hi.y; ++c.y)
              for (c.z = lo.z; c.z < hi.z; ++c.z)
                if (left.test(left.index(c))) {
                  left.clear(left.index(c));
                  part.push_back(c);
                }
        }
        if (double(part.size()) >= needed)
          for (const Int3& c : part) out.set(out.index(c));
      }
  return out;
}

Box bounding_box(const BitGrid& grid, float margin) {
  Int3 lo = grid.size, hi{-1, -1, -1}, c;
  for (c.x = 0; c.x < grid.size.x; ++c.x)
    for (c.y = 0; c.y < grid.size.y; ++c.y)
      for (c.z = 0; c.z < grid.size.z; ++c.z)
        if (grid.test(grid.index(c))) lo = min(lo, c), hi = max(hi, c);
  if (hi.x < 0) lo = {0, 0, 0}, hi = grid.size - Int3{1, 1, 1};
  Box box{grid.origin + grid.cell * cast<float>(lo), grid.origin + grid.cell * cast<float>(hi + Int3{1, 1, 1})};
  const Vec3 e = box.extent();
  const float m = margin * std::max({e.x, e.y, e.z});
  box.lo -= Vec3{m, m, m}, box.hi += Vec3{m, m, m};
  return box;
}

BitGrid canonical_occupancy(const VoxelModel& model, int cells, float alpha, float step) {
  const RadianceField& field = model.radiance;
  const Topology& topology = *field.raw.topology;
  const Lattice& lattice = topology.lattice;
  BitGrid grid(model.box, cells);
  // alpha >= a  <=>  softplus(raw + shift) >= -log(1 - a) / (scale step)  <=>  raw >= log(expm1(that)) - shift.
  const double depth = -std::log1p(-double(alpha)) / (double(field.activation.scale) * step);
  const float threshold = float(std::log(std::expm1(depth)) - field.activation.shift);
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      if (!(field.raw.row(std::size_t(b) * kBrickRows + i)[0] >= threshold)) continue;
      const Int3 brick = topology.bricks[b];
      const Vec3 x = lattice.position({brick.x * kBrick + (i >> 6), brick.y * kBrick + (i >> 3 & 7), brick.z * kBrick + (i & 7)});
      const Vec3 reach{lattice.spacing, lattice.spacing, lattice.spacing};
      const Int3 lo = grid.cell_of(x - reach), hi = grid.cell_of(x + reach);
      for (int cx = lo.x; cx <= hi.x; ++cx)
        for (int cy = lo.y; cy <= hi.y; ++cy)
          for (int cz = lo.z; cz <= hi.z; ++cz) grid.set(grid.index({cx, cy, cz}));
    }
  return dilate(grid);
}

BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice, const BitGrid& canonical) {
  if (!slice.topology) return canonical;
  const WarpedLookup warped(model, slice);
  // Blocks of 4 cells an edge first: where a whole block is warped into nothing, its cells need no look.
  constexpr int kBlock = 4;
  const BitGrid coarse_canonical = dilate(coarsen(canonical, kBlock));
  BitGrid out = canonical;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  const OccupancyView<float> fine = canonical.view(), coarse = coarse_canonical.view();
  Int3 b;
  for (b.x = 0; b.x < coarse_canonical.size.x; ++b.x)
    for (b.y = 0; b.y < coarse_canonical.size.y; ++b.y)
      for (b.z = 0; b.z < coarse_canonical.size.z; ++b.z) {
        if (!coarse.occupied(warped(coarse_canonical.center(b)))) continue;
        const Int3 first{b.x * kBlock, b.y * kBlock, b.z * kBlock};
        const Int3 last = min(out.size, first + Int3{kBlock, kBlock, kBlock});
        Int3 c;
        for (c.x = first.x; c.x < last.x; ++c.x)
          for (c.y = first.y; c.y < last.y; ++c.y)
            for (c.z = first.z; c.z < last.z; ++c.z)
              if (fine.occupied(warped(out.center(c)))) out.set(out.index(c));
      }
  return out;
}

}  // namespace splinevox
