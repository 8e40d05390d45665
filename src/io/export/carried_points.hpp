// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/export/view_bake.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

/// When frames are: model times, and units of model time per second at them.
struct FrameTimes {
  std::vector<double> times, rates;  ///< [frames]
};
FrameTimes frame_times(const FrameRange& range, const std::vector<int>& frames);

/// Velocities of the matter at places of one time, scene units per second.
/// @param rate  units of model time per second
std::vector<Vec3> velocities_at(const VoxelModel& model, double time, double rate,
                                std::span<const Vec3> places);

/// Points that the matter carries along.
struct CarriedPoints {
  std::vector<std::int64_t> ids;  ///< [points]
  std::vector<Vec3> colors;       ///< [points] display values where they are at the first frame
  std::vector<std::vector<Vec3>> places, velocities;  ///< [frames][points] scene units, and those per second
  std::vector<std::vector<bool>> lost;                ///< [frames][points] the way there is not to be trusted
  double untracked = 0;                               ///< share of the places that are lost
};

/// Carries points to the frames (field/sample.hpp, track).
/// @pre points.time has a time for every point, points.id a number
CarriedPoints carry_points(const VoxelModel& model, const ExportPoints& points, const FrameTimes& frames,
                           const ViewBake& view);

}  // namespace splinevox
