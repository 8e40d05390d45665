// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "run/training_cameras.hpp"
#include "splinevox/run/cameras.hpp"

namespace splinevox::run {

/// Where pictures were taken, for a page that keeps near there.
struct TakenFrom {
  Vec3d middle;                   ///< of what they look at, scene units
  std::vector<Vec3d> directions;  ///< from there to the cameras: unit vectors, 96 at most
  double near, far;               ///< distances from there to the cameras: the least and the largest
  double spacing;                 ///< largest angle from a camera to its nearest neighbour, radians
};

/// Absent where cameras surround the scene: there nothing is kept from anybody.
std::optional<TakenFrom> taken_from(const TrainingCameras& train);

}  // namespace splinevox::run
