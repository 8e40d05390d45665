// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "render/occupancy.hpp"

/// Occupancy of matter that comes and goes: bounds of raw density and presence, cell by cell.
namespace splinevox {

/// The largest raw density of the vertices within one vertex of a canonical cell.
CellValues raw_peaks(const RadianceField& field, const CellGrid& cells);

/// The peaks of a model whose canonical occupancy has these levels.
/// @param threshold  raw density of the alpha that counts
PresencePeaks presence_peaks(const VoxelModel& model, float threshold, std::span<const BitGrid> levels);

/// frame_occupancy of a pyramid with peaks.
BitGrid frame_occupancy_of_presence(const VoxelModel& model, const MotionSlice& slice,
                                    const OccupancyPyramid& canonical);

}  // namespace splinevox
