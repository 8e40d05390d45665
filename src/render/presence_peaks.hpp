// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"
#include "render/occupancy.hpp"

/// Occupancy of matter that comes and goes: bounds of raw density and presence, cell by cell.
namespace splinevox {

/// Raw density from which on a step has an alpha.
///
/// alpha >= a  <=>  softplus(raw + shift) >= -log(1 - a) / (scale step)  <=>  raw >= inverse_softplus(that) -
/// shift.
inline float raw_of(float alpha, const DensityActivation& activation, float step) {
  return float(inverse_softplus(optical_depth(alpha) / (double(activation.scale) * step)) - activation.shift);
}

/// Whether a model's matter may come and go.
inline bool comes_and_goes(const MotionField& motion) { return motion.presence && !motion.levels.empty(); }

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
CellValues raw_peaks(const RadianceField& field, const BitGrid& cells);

/// The largest presence with which a canonical cell is looked up at any of some times; at least 0, which its
/// mean over time has.
CellValues looked_up_presence(const VoxelModel& model, const BitGrid& cells);

/// The peaks of a model whose canonical occupancy has these levels.
/// @param threshold  raw density of the alpha that counts
PresencePeaks presence_peaks(const VoxelModel& model, float threshold, std::span<const BitGrid> levels);

/// frame_occupancy of a pyramid with peaks.
BitGrid frame_occupancy_of_presence(const VoxelModel& model, const MotionSlice& slice,
                                    const OccupancyPyramid& canonical);

}  // namespace splinevox
