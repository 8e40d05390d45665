// SPDX-License-Identifier: Apache-2.0
#include "render/presence_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "field/lattice/slice.hpp"
#include "render/warped_centers.hpp"

namespace splinevox {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

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
      float most = kNothing;
      for (int k = 0; k < by.count; ++k) {
        if (basis.per_node == 1)
          raise(most, row[stride * k]);
        else if (basis.is_place(k))
          raise(most, row[stride * k] + per_velocity * std::abs(row[stride * (k + 1)]));
      }
      const float mean = by.mean_at(row);
      visit_around(out.grid, topology.position(b, i), topology.lattice.spacing,
                   [&](std::size_t c) { raise(out.values[c], most - mean); });
    }
  return out;
}

}  // namespace

CellValues::CellValues(BitGrid cells, float everywhere) : grid(std::move(cells)) {
  grid.bits.clear();
  values.assign(grid.cells(), everywhere);
}

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

PresencePeaks presence_peaks(const VoxelModel& model, float threshold, std::span<const BitGrid> levels) {
  PresencePeaks out;
  out.threshold = threshold;
  out.raw.push_back(dilate(raw_peaks(model.radiance, levels[0])));
  out.most.push_back(most_presence(model.motion, levels[0]));
  for (std::size_t l = 1; l < levels.size(); ++l) {
    out.raw.push_back(dilate(coarsen(out.raw[0], levels[l], 1 << l)));
    out.most.push_back(coarsen(out.most[0], levels[l], 1 << l));
  }
  return out;
}

BitGrid frame_occupancy_of_presence(const VoxelModel& model, const MotionSlice& slice,
                                    const OccupancyPyramid& canonical) {
  const PresencePeaks& peaks = *canonical.presence;
  BitGrid out = canonical.levels[0];
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  std::vector<WarpedCenters> warped;
  for (const BitGrid& level : canonical.levels) warped.emplace_back(model, slice, level);
  canonical.descend([&](int level, const Int3& c) {
    const auto w = warped[level].at(c);
    const float raw = peaks.raw[level].at(w.position);
    if (level > 0) return raw + peaks.most[level].values[peaks.most[level].grid.index(c)] >= peaks.threshold;
    if (raw + w.presence >= peaks.threshold) out.set(out.index(c));
    return false;
  });
  // The corners of a motion cell are all around a grid's cell unless that is the larger one.
  return out.cell > slice.topology->lattice.spacing ? dilate(out) : out;
}

}  // namespace splinevox
