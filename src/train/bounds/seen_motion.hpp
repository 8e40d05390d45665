// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/cameras.hpp"
#include "train/occupancy.hpp"

namespace splinevox {

/// Motion of the matter that training pictures show in a cell of observed space. Samples weigh by their share
/// in the pixel.
struct VisibleMotion {
  int times = 0;       ///< different ones at which the cell is visible; 0: nothing is known of it
  double weight = 0;   ///< of all samples there in their pixels
  Vec3 offset{};       ///< mean displacement, scene units
  float spread = 0;    ///< of the displacement over time: its standard deviation, scene units
  float light = 0;     ///< the same of the light's gain
  float presence = 0;  ///< the same of presence
  float error = 0;     ///< the same of the mean error of the rays that meet the cell, per channel
};

/// Marches a fixed number of rays through `views`, or through a few hundred of them spread over time.
/// @param occupancy  of the views, if anything is known of it
/// @param cameras  what is known of them
/// @pre something changes over time in the model
std::vector<VisibleMotion> visible_motion(const VoxelModel& model, const Split& views,
                                          const FrameOccupancy& occupancy, const BitGrid& cells,
                                          const CameraFits& cameras = {});

}  // namespace splinevox
