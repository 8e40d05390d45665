// SPDX-License-Identifier: Apache-2.0
#include "render/occupancy.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "field/warped_centers.hpp"
#include "math/activation.hpp"
#include "render/presence_peaks.hpp"

namespace splinevox {
namespace {

/// ORs each cell with its two neighbours along one axis.
BitGrid dilate_axis(const BitGrid& in, int axis) {
  BitGrid out = in;
  const std::size_t stride = axis == 0   ? std::size_t(in.size.y) * in.size.z
                             : axis == 1 ? std::size_t(in.size.z)
                                         : 1;
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
  out.origin = in.origin;
  out.cell = in.cell * float(n);
  for (int a = 0; a < 3; ++a) out.size[a] = (in.size[a] + n - 1) / n;
  out.bits.assign((out.cells() + 31) / 32, 0);
  Int3 c;
  for (c.x = 0; c.x < in.size.x; ++c.x)
    for (c.y = 0; c.y < in.size.y; ++c.y)
      for (c.z = 0; c.z < in.size.z; ++c.z)
        if (in.test(in.index(c))) out.set(out.index({c.x / n, c.y / n, c.z / n}));
  return out;
}

/// The cells that are not set.
BitGrid inverse(const BitGrid& grid) {
  BitGrid out = grid;
  for (std::uint32_t& word : out.bits) word = ~word;
  return out;
}

/// Raw density from which on a step has an alpha.
float raw_of_step(float alpha, const DensityActivation& activation, float step) {
  return raw_of_alpha(alpha, activation.scale, activation.shift, step);
}

}  // namespace

BitGrid::BitGrid(const CellGrid& cells) : CellGrid(cells), bits((cells.cells() + 31) / 32, 0u) {}

std::size_t BitGrid::count() const {
  std::size_t n = 0;
  for (const std::uint32_t word : bits) n += std::popcount(word);
  return n;
}

bool BitGrid::any(Vec3 lo, Vec3 hi) const {
  const Int3 first = cell_of(lo), last = cell_of(hi);
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y)
      for (int z = first.z; z <= last.z; ++z)
        if (test(index({x, y, z}))) return true;
  return false;
}

BitGrid& BitGrid::operator|=(const BitGrid& other) {
  for (std::size_t w = 0; w < bits.size(); ++w) bits[w] |= other.bits[w];
  return *this;
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
          const Int3 at = part[next], lo = max(at - Int3{1, 1, 1}, Int3{0, 0, 0}),
                     hi = min(at + Int3{2, 2, 2}, grid.size);
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
        if (grid.test(grid.index(c))) {
          lo = min(lo, c);
          hi = max(hi, c);
        }
  if (hi.x < 0) {
    lo = {0, 0, 0};
    hi = grid.size - Int3{1, 1, 1};
  }
  Box box{grid.origin + grid.cell * cast<float>(lo),
          grid.origin + grid.cell * cast<float>(hi + Int3{1, 1, 1})};
  const float m = margin * box.longest_edge();
  box.lo -= Vec3{m, m, m};
  box.hi += Vec3{m, m, m};
  return box;
}

BitGrid canonical_occupancy(const VoxelModel& model, int cells, float alpha, float step) {
  return canonical_occupancy(model, LargestPresence(model, cells), alpha, step);
}

BitGrid canonical_occupancy(const VoxelModel& model, const LargestPresence& presence, float alpha,
                            float step) {
  const RadianceField& field = model.radiance;
  const Topology& topology = *field.raw.topology;
  BitGrid grid(presence.cells().grid);
  const float threshold = raw_of_step(alpha, field.activation, step);
  if (presence.any()) {
    const CellValues raw = raw_peaks(field, grid);
    for (std::size_t i = 0; i < grid.cells(); ++i)
      if (raw.values[i] + presence.cells().values[i] >= threshold) grid.set(i);
    return dilate(grid);
  }
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      if (field.raw.row(std::size_t(b) * kBrickRows + i)[0] >= threshold)
        visit_around(grid, topology.position(b, i), topology.lattice.spacing,
                     [&](std::size_t c) { grid.set(c); });
  return dilate(grid);
}

OccupancyPyramid::OccupancyPyramid(const VoxelModel& model, int cells, float alpha, float step, BitGrid reach)
    : OccupancyPyramid(comes_and_goes(model.motion) ? BitGrid(model.box, cells)
                                                    : canonical_occupancy(model, cells, alpha, step),
                       std::move(reach)) {
  if (comes_and_goes(model.motion))
    presence = presence_peaks(model, raw_of_step(alpha, model.radiance.activation, step), levels);
}

OccupancyPyramid::OccupancyPyramid(BitGrid canonical, BitGrid reach)
    : levels{{std::move(canonical), {}, {}}}, moving{{std::move(reach), {}, {}}} {
  const BitGrid holes = inverse(levels[0]);
  // A block is warped by its centre alone, hence the margin of one block.
  for (int l = 1; l < kLevels; ++l) {
    levels[l] = dilate(coarsen(levels[0], 1 << l));
    full[l] = inverse(dilate(coarsen(holes, 1 << l)));
  }
  for (int l = 1; l < kLevels && moving[0].cells() > 0; ++l) moving[l] = coarsen(moving[0], 1 << l);
}

BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice,
                        const OccupancyPyramid& canonical) {
  const BitGrid& cells = canonical.levels[0];
  if (canonical.presence) return frame_occupancy_of_presence(model, slice, canonical);
  if (!slice.topology || !model.motion.displaces) return cells;
  BitGrid out = cells;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  std::array<OccupancyView<float>, OccupancyPyramid::kLevels> views, full;
  std::vector<WarpedCenters> warped;
  for (int l = 0; l < OccupancyPyramid::kLevels; ++l) {
    views[l] = canonical.levels[l].view();
    full[l] = canonical.full[l].view();
    warped.emplace_back(model, slice, canonical.levels[l]);
  }
  const auto set_parts = [&](int level, Int3 block, const auto& is_set) {
    const Int3 first = (1 << level) * block, last = min(cells.size, (1 << level) * (block + Int3{1, 1, 1}));
    Int3 c;
    for (c.x = first.x; c.x < last.x; ++c.x)
      for (c.y = first.y; c.y < last.y; ++c.y)
        for (c.z = first.z; c.z < last.z; ++c.z)
          if (const std::size_t i = cells.index(c); is_set(i)) out.set(i);
  };
  // What is not displaced is where it is, and where a whole block is warped into nothing, or to where
  // everything is occupied, its parts need no look.
  const bool known = canonical.moving[0].cells() > 0;
  canonical.descend([&](int level, const Int3& first) {
    return [&, level, to = std::optional<WarpedCenters::Eight>()](int corner, const Int3& c) mutable {
      if (known && !canonical.moving[level].test(canonical.moving[level].index(c))) {
        set_parts(level, c, [&](std::size_t i) { return cells.test(i); });
        return false;
      }
      if (!to) to = warped[level].eight(first);
      const Vec3 at = to->at(corner);
      if (level > 0 && full[level].occupied(at)) {
        set_parts(level, c, [](std::size_t) { return true; });
        return false;
      }
      const bool there = views[level].occupied(at);
      if (level == 0 && there) out.set(out.index(c));
      // Of a block of which a part is displaced, the rest is looked at cell by cell.
      return level > 0 &&
             (there || (known && canonical.levels[level].test(canonical.levels[level].index(c))));
    };
  });
  return out;
}

}  // namespace splinevox
