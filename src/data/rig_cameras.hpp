// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Finds out which camera took which frame, sets RawFrame::camera_id, and gives the cameras.
///
/// A camera is told by its name where every frame has one (RawFrame::camera), else by pose and lens: frames
/// that agree in both are of one camera that stands still. Where no camera has two moments there is no rig:
/// every id is -1 and there are no cameras. Neither is one where poses that repeat have less than a quarter
/// of the frames: a way that closes.
/// @pre frames have their times
std::vector<RigCamera> settle_cameras(std::vector<RawSplit>& splits);

/// The cameras to hold out of a rig whose data names no test split: one of every eight, one at least, where
/// five or more stand still and each sees nine tenths of all moments (seen_moments.hpp); else none. Cameras
/// are divided in the order in which people count their names, into parts of equal size; of each part it is
/// the one nearest to the middle of their places. A camera at the end of a rig has neighbours on one side
/// alone.
/// @param split  all frames  @return their numbers in `cameras`, ascending
std::vector<int> cameras_to_hold_out(const RawSplit& split, const std::vector<RigCamera>& cameras);

}  // namespace splinevox::data
