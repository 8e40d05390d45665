// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/render_frames.hpp"
#include "io/export/usd_stage.hpp"

namespace splinevox::cli {

/// Names of the two files that write_cameras writes are this and kCamerasUsd.
constexpr const char* kCamerasJson = "cameras.json";

/// The cameras of the shown frames as pinhole cameras, for other programs: in `folder`, cameras.json (what
/// `render --camera` and load_in_blender.py read; times are the data's own) and cameras.usda (a Camera whose
/// time codes are frame numbers). Throws Error (output). @param times  of the run
void write_cameras(const std::string& folder, const RenderFrames& frames, double fps, const TimeMap& times);

}  // namespace splinevox::cli
