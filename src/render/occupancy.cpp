// SPDX-License-Identifier: Apache-2.0
#include "render/occupancy.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/simd.hpp"
#include "field/lattice/brick_view.hpp"
#include "math/activation.hpp"
#include "math/warp.hpp"

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

/// x + Delta(x) of a slice at the centres of a grid's cells. What a coordinate means for the lattice is
/// looked up in a table per axis: finding the rows would cost more than reading them.
class WarpedCenters {
 public:
  WarpedCenters(const VoxelModel& model, const MotionSlice& slice, const BitGrid& grid)
      : view_(*slice.topology),
        values_(slice.values.data()),
        rigidity_(model.motion.rigidity),
        offset_(model.motion.rigidity_offset) {
    const std::int32_t slots[3] = {view_.stride_x, view_.stride_y, 1}, locals[3] = {64, 8, 1};
    for (int a = 0; a < 3; ++a) {
      axis_[a].resize(grid.size[a]);
      for (int c = 0; c < grid.size[a]; ++c) {
        // The last block of an axis may reach beyond the box, where nothing is stored.
        const float x = std::min(grid.center({c, c, c})[a], model.box.hi[a]), u = view_.coordinate(x, a);
        const int vertex = int(u);
        axis_[a][c] = {{(vertex >> 3) * slots[a], (vertex & 7) * locals[a]}, u - float(vertex), x};
      }
    }
  }

  Vec3 operator()(Int3 c) const { return at(c).position; }

  struct Warped {
    Vec3 position;   ///< x + Delta(x)
    float presence;  ///< the largest of the corners of the motion cell
  };
  Warped at(Int3 c) const {
    using Four = Simd<float>::Four;
    const Entry &x = axis_[0][c.x], &y = axis_[1][c.y], &z = axis_[2][c.z];
    const CellRows rows =
        view_.rows({x.cell.slot + y.cell.slot + z.cell.slot, x.cell.local + y.cell.local + z.cell.local});
    float w[kCorners];
    trilinear_weights(Vec3{x.fraction, y.fraction, z.fraction}, w);
    Four m{};
    float presence = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < kCorners; ++i) {
      const float* row = values_ + std::size_t(rows.row[i]) * kSliceWidth;
      m += w[i] * load<Four>(row);
      presence = std::max(presence, row[kSliceScalars + kPresence]);
    }
    const float r = rigidity_ ? rigidity_of(m[3], offset_).value : 1.0f;
    return {Vec3{x.position, y.position, z.position} + displacement_of(m, r), presence};
  }

 private:
  struct Entry {
    Cell cell;  ///< this axis' share of slot and local
    float fraction, position;
  };
  BrickView<float> view_;
  const float* values_;
  bool rigidity_;
  float offset_;
  std::vector<Entry> axis_[3];
};

}  // namespace

namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

/// Raw density from which on a step has an alpha.
///
/// alpha >= a  <=>  softplus(raw + shift) >= -log(1 - a) / (scale step)  <=>  raw >= inverse_softplus(that) -
/// shift.
float raw_of(float alpha, const DensityActivation& activation, float step) {
  return float(inverse_softplus(optical_depth(alpha) / (double(activation.scale) * step)) - activation.shift);
}

bool comes_and_goes(const MotionField& motion) { return motion.presence && !motion.levels.empty(); }

void raise(float& most, float value) {
  if (value > most) most = value;
}

/// Each cell's largest value among its own and those of its neighbours, diagonals included.
CellValues dilate(CellValues in) {
  const Int3 size = in.grid.size;
  for (int axis = 0; axis < 3; ++axis) {
    const CellValues from = in;
    const std::size_t stride = axis == 0 ? std::size_t(size.y) * size.z : axis == 1 ? std::size_t(size.z) : 1;
    Int3 c;
    for (c.x = 0; c.x < size.x; ++c.x)
      for (c.y = 0; c.y < size.y; ++c.y)
        for (c.z = 0; c.z < size.z; ++c.z) {
          const std::size_t i = in.grid.index(c);
          if (c[axis] > 0) raise(in.values[i], from.values[i - stride]);
          if (c[axis] + 1 < size[axis]) raise(in.values[i], from.values[i + stride]);
        }
  }
  return in;
}

/// The largest value in blocks of n cells an edge. @param blocks  their grid
CellValues coarsen(const CellValues& in, const BitGrid& blocks, int n) {
  CellValues out(blocks, kNothing);
  Int3 c;
  for (c.x = 0; c.x < in.grid.size.x; ++c.x)
    for (c.y = 0; c.y < in.grid.size.y; ++c.y)
      for (c.z = 0; c.z < in.grid.size.z; ++c.z)
        raise(out.values[out.grid.index({c.x / n, c.y / n, c.z / n})], in.values[in.grid.index(c)]);
  return out;
}

/// Calls visit(cell) for the cells within one vertex of a vertex.
template <class Visit>
void visit_around(const BitGrid& grid, const Vec3& x, float spacing, Visit&& visit) {
  const Vec3 reach{spacing, spacing, spacing};
  const Int3 lo = grid.cell_of(x - reach), hi = grid.cell_of(x + reach);
  for (int cx = lo.x; cx <= hi.x; ++cx)
    for (int cy = lo.y; cy <= hi.y; ++cy)
      for (int cz = lo.z; cz <= hi.z; ++cz) visit(grid.index({cx, cy, cz}));
}

/// The largest raw density of the vertices within one vertex of a canonical cell.
CellValues raw_peaks(const RadianceField& field, const BitGrid& cells) {
  CellValues out(cells, kNothing);
  const Topology& topology = *field.raw.topology;
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float raw = field.raw.row(std::size_t(b) * kBrickRows + i)[0];
      visit_around(out.grid, topology.position(b, i), topology.lattice.spacing,
                   [&](std::size_t c) { raise(out.values[c], raw); });
    }
  return out;
}

/// A bound of the presence at any time around an observed cell: a curve stays below the largest point of its
/// control polygon.
CellValues most_presence(const MotionField& motion, const BitGrid& cells) {
  CellValues out(cells, 0.0f);  // where nothing is stored
  const Channels& level = motion.levels.back();
  const Topology& topology = *level.topology;
  const Contraction by(motion);
  const Basis& basis = basis_of(motion.basis);
  const int place = by.layout.scalar[kPresence], stride = by.layout.stride;
  const float per_velocity = 1.0f / (3.0f * float(basis.pieces(motion.points)));  // of a Hermite curve
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float* row = level.row(std::size_t(b) * kBrickRows + i) + place;
      float most = kNothing, mean = 0;
      for (int k = 0; k < by.points; ++k) {
        mean += by.mean[k] * row[stride * k];
        if (basis.per_node == 1)
          raise(most, row[stride * k]);
        else if (basis.is_place(k))
          raise(most, row[stride * k] + per_velocity * std::abs(row[stride * (k + 1)]));
      }
      visit_around(out.grid, topology.position(b, i), topology.lattice.spacing,
                   [&](std::size_t c) { raise(out.values[c], most - mean); });
    }
  return out;
}

/// The largest presence with which a canonical cell is looked up at any of some times; at least 0, which its
/// mean over time has.
CellValues looked_up_presence(const VoxelModel& model, const BitGrid& cells) {
  const MotionField& motion = model.motion;
  CellValues out = most_presence(motion, cells);
  if (!motion.displaces) return out;
  std::fill(out.values.begin(), out.values.end(), 0.0f);
  const int times = 3 * motion.points;
  MotionSlice slice;
  for (int i = 0; i <= times; ++i) {
    fill_slice(motion, parameter_weights(motion, double(i) / times), slice);
    const WarpedCenters warped(model, slice, cells);
    Int3 c;
    for (c.x = 0; c.x < cells.size.x; ++c.x)
      for (c.y = 0; c.y < cells.size.y; ++c.y)
        for (c.z = 0; c.z < cells.size.z; ++c.z) {
          const auto w = warped.at(c);
          raise(out.values[cells.index(cells.cell_of(w.position))], w.presence);
        }
  }
  return dilate(std::move(out));
}

BitGrid frame_occupancy_of_presence(const VoxelModel& model, const MotionSlice& slice,
                                    const OccupancyPyramid& canonical) {
  const PresencePeaks& peaks = *canonical.presence;
  BitGrid out = canonical.levels[0];
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  std::vector<WarpedCenters> warped;
  for (const BitGrid& level : canonical.levels) warped.emplace_back(model, slice, level);
  const auto descend = [&](const auto& self, int level, Int3 c) -> void {
    const auto w = warped[level].at(c);
    const float raw = peaks.raw[level].at(w.position);
    if (level == 0) {
      if (raw + w.presence >= peaks.threshold) out.set(out.index(c));
      return;
    }
    if (!(raw + peaks.most[level].values[peaks.most[level].grid.index(c)] >= peaks.threshold)) return;
    const Int3 first = 2 * c, last = min(canonical.levels[level - 1].size, first + Int3{2, 2, 2});
    Int3 part;
    for (part.x = first.x; part.x < last.x; ++part.x)
      for (part.y = first.y; part.y < last.y; ++part.y)
        for (part.z = first.z; part.z < last.z; ++part.z) self(self, level - 1, part);
  };
  constexpr int kTop = OccupancyPyramid::kLevels - 1;
  Int3 b;
  for (b.x = 0; b.x < canonical.levels[kTop].size.x; ++b.x)
    for (b.y = 0; b.y < canonical.levels[kTop].size.y; ++b.y)
      for (b.z = 0; b.z < canonical.levels[kTop].size.z; ++b.z) descend(descend, kTop, b);
  // The corners of a motion cell are all around a grid's cell unless that is the larger one.
  return out.cell > slice.topology->lattice.spacing ? dilate(out) : out;
}

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

CellValues::CellValues(BitGrid cells, float everywhere) : grid(std::move(cells)) {
  grid.bits.clear();
  values.assign(grid.cells(), everywhere);
}

BitGrid canonical_occupancy(const VoxelModel& model, int cells, float alpha, float step) {
  const RadianceField& field = model.radiance;
  const Topology& topology = *field.raw.topology;
  BitGrid grid(model.box, cells);
  const float threshold = raw_of(alpha, field.activation, step);
  if (comes_and_goes(model.motion)) {
    const CellValues raw = raw_peaks(field, grid), presence = looked_up_presence(model, grid);
    for (std::size_t i = 0; i < grid.cells(); ++i)
      if (raw.values[i] + presence.values[i] >= threshold) grid.set(i);
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
  if (!comes_and_goes(model.motion)) return;
  PresencePeaks& peaks = presence.emplace();
  peaks.threshold = raw_of(alpha, model.radiance.activation, step);
  peaks.raw.push_back(dilate(raw_peaks(model.radiance, levels[0])));
  peaks.most.push_back(most_presence(model.motion, levels[0]));
  for (int l = 1; l < kLevels; ++l) {
    peaks.raw.push_back(dilate(coarsen(peaks.raw[0], levels[l], 1 << l)));
    peaks.most.push_back(coarsen(peaks.most[0], levels[l], 1 << l));
  }
}

OccupancyPyramid::OccupancyPyramid(BitGrid canonical, BitGrid reach)
    : levels{{std::move(canonical), {}, {}}}, moving{{std::move(reach), {}, {}}} {
  // A block is warped by its centre alone, hence the margin of one block.
  for (int l = 1; l < kLevels; ++l) levels[l] = dilate(coarsen(levels[0], 1 << l));
  for (int l = 1; l < kLevels && moving[0].cells() > 0; ++l) moving[l] = coarsen(moving[0], 1 << l);
}

BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice,
                        const OccupancyPyramid& canonical) {
  const BitGrid& cells = canonical.levels[0];
  if (canonical.presence) return frame_occupancy_of_presence(model, slice, canonical);
  if (!slice.topology || !model.motion.displaces) return cells;
  BitGrid out = cells;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  std::array<OccupancyView<float>, OccupancyPyramid::kLevels> views;
  std::vector<WarpedCenters> warped;
  for (int l = 0; l < OccupancyPyramid::kLevels; ++l) {
    views[l] = canonical.levels[l].view();
    warped.emplace_back(model, slice, canonical.levels[l]);
  }
  const auto copy = [&](int level, Int3 block) {
    const Int3 first = (1 << level) * block, last = min(cells.size, (1 << level) * (block + Int3{1, 1, 1}));
    Int3 c;
    for (c.x = first.x; c.x < last.x; ++c.x)
      for (c.y = first.y; c.y < last.y; ++c.y)
        for (c.z = first.z; c.z < last.z; ++c.z)
          if (const std::size_t i = cells.index(c); cells.test(i)) out.set(i);
  };
  // What is not displaced is where it is, and where a whole block is warped into nothing, its parts need no
  // look.
  const bool known = canonical.moving[0].cells() > 0;
  const auto descend = [&](const auto& self, int level, Int3 c) -> void {
    if (known && !canonical.moving[level].test(canonical.moving[level].index(c))) return copy(level, c);
    if (!views[level].occupied(warped[level](c))) return;
    if (level == 0) return out.set(out.index(c));
    const Int3 first = 2 * c, last = min(canonical.levels[level - 1].size, first + Int3{2, 2, 2});
    Int3 part;
    for (part.x = first.x; part.x < last.x; ++part.x)
      for (part.y = first.y; part.y < last.y; ++part.y)
        for (part.z = first.z; part.z < last.z; ++part.z) self(self, level - 1, part);
  };
  constexpr int kTop = OccupancyPyramid::kLevels - 1;
  const Int3 size = canonical.levels[kTop].size;
  Int3 b;
  for (b.x = 0; b.x < size.x; ++b.x)
    for (b.y = 0; b.y < size.y; ++b.y)
      for (b.z = 0; b.z < size.z; ++b.z) descend(descend, kTop, b);
  return out;
}

}  // namespace splinevox
