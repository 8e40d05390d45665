// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/options.hpp"
#include "splinevox/run/cameras.hpp"

namespace splinevox::cli {

/// The pictures of one call of `render`: a part of a shot.
struct RenderFrames {
  std::vector<Shot> shots;         ///< of the whole shot
  std::vector<std::size_t> shown;  ///< those to render
  std::vector<int> numbers;        ///< of their files
  std::vector<char> held;  ///< whether each is beyond the motion's ends, where camera and matter stand still
};

/// Cameras and times of what is asked for. With `frames`, a shot has a camera for every frame over which the
/// whole motion runs, and any part of it has the cameras and times of the whole; frames outside have those of
/// its ends. A file of cameras with numbers (numbered_cameras) has those of the frames of these numbers, if
/// it has any of them.
/// @param frames  FrameWords::frames is empty where the option was not given
/// Throws Error (input).
RenderFrames plan_frames(const Run& run, CameraRequest cameras, const FrameWords& frames,
                         const std::function<void(const std::string&)>& on_note);

}  // namespace splinevox::cli
