// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/occupancy.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// What pictures of different times show of the motion in a cell of observed space: each time as much as it
/// shows.
struct SeenMotion {
  int times = 0;      ///< different ones that show the cell; 0: nothing is known of it
  double weight = 0;  ///< of all samples there in their pixels
  Vec3 offset{};      ///< mean displacement, scene units
  float spread = 0;   ///< of the displacement over time: its standard deviation, scene units
  float light = 0;    ///< the same of the light's gain
  float error = 0;    ///< the same of the mean error of the rays that meet the cell, per channel
};

/// Looks at `views`, or at a few hundred of them spread over time, along a fixed number of rays.
/// @param occupancy  of each view, as Trainer has it: one grid each, one for all, or none
/// @pre something changes over time in the model
std::vector<SeenMotion> seen_motion(const VoxelModel& model, const Split& views,
                                    const std::vector<BitGrid>& occupancy, const BitGrid& cells);

}  // namespace splinevox
