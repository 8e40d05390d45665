// SPDX-License-Identifier: Apache-2.0
#include "render/presence_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "field/warped_centers.hpp"

namespace splinevox {
namespace {

/// The largest value in blocks of n cells an edge. @param blocks  their grid
CellValues coarsen(const CellValues& in, const CellGrid& blocks, int n) {
  CellValues out(blocks, CellValues::kLowest);
  Int3 c;
  for (c.x = 0; c.x < in.grid.size.x; ++c.x)
    for (c.y = 0; c.y < in.grid.size.y; ++c.y)
      for (c.z = 0; c.z < in.grid.size.z; ++c.z)
        out.raise(out.grid.index({c.x / n, c.y / n, c.z / n}), in.values[in.grid.index(c)]);
  return out;
}

/// Whether no cell reaches into two cells of a lattice.
bool nests(const CellGrid& cells, const Lattice& lattice) {
  constexpr float kSame = 1e-3f;  // of a cell
  const auto whole = [](float x) { return std::abs(x - std::round(x)) < kSame; };
  bool out = lattice.spacing > (1 - kSame) * cells.cell && whole(lattice.spacing / cells.cell);
  for (int a = 0; a < 3; ++a) out &= whole((lattice.origin[a] - cells.origin[a]) / cells.cell);
  return out;
}

}  // namespace

CellValues raw_peaks(const RadianceField& field, const CellGrid& cells) {
  CellValues out(cells, CellValues::kLowest);
  const Topology& topology = *field.raw.topology;
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float raw = field.raw.row(std::size_t(b) * kBrickRows + i)[0];
      visit_around(out.grid, topology.position(b, i), topology.lattice.spacing,
                   [&](std::size_t c) { out.raise(c, raw); });
    }
  return out;
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
  canonical.descend([&](int level, const Int3& first) {
    return [&, level, to = warped[level].eight(first)](int corner, const Int3& c) {
      const float raw = peaks.raw[level].at(to.at(corner));
      if (level > 0)
        return raw + peaks.most[level].values[peaks.most[level].grid.index(c)] >= peaks.threshold;
      if (raw + to.presence[corner] >= peaks.threshold) out.set(out.index(c));
      return false;
    };
  });
  // Only a grid's cell that lies within one motion cell has all of its corners around it.
  return nests(out, slice.topology->lattice) ? out : dilate(out);
}

}  // namespace splinevox
