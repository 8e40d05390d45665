// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Finds out which camera took which frame, sets RawFrame::camera_id, and gives the cameras.
///
/// A camera is told by its name where every frame has one (RawFrame::camera), else by pose and lens: frames
/// that agree in both are of one camera that stands still. Where no camera has two moments there is no rig:
/// every id is -1 and there are no cameras.
/// @pre frames have their times
std::vector<RigCamera> settle_cameras(std::vector<RawSplit>& splits);

}  // namespace splinevox::data
