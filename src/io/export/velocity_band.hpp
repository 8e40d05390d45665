// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/vdb/leaf_values.hpp"

namespace splinevox {

struct VelocityBand {
  LeafValues values;  ///< those given, and those beyond
  int padding = 0;    ///< layers of voxels beyond
  int missing = 0;    ///< further layers that the fastest of the last asked for
};

/// Velocities beyond the voxels that have one: motion blur looks for what moves into a place in that place.
/// Layer by layer a voxel gets the mean of those beside it that are known. From a velocity as many layers go
/// on as matter of that velocity moves, and one more, for interpolation. So still matter gets one, and a
/// voxel that is wrongly fast is soon averaged away.
/// @param voxels_per_speed  how far matter moves in half the shutter, by the length of its velocity
VelocityBand spread_velocity(LeafValues core, double voxels_per_speed);

}  // namespace splinevox
