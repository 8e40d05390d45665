// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/render_frames.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::cli {

/// Names that --layers knows, as a list for messages.
std::string layer_names();

/// What --layers asks for. Throws Error (input): an unknown name, one that the format has no room for, or two
/// that are the same channels.
std::vector<std::string> chosen_layers(const std::string& text, const std::string& format);

/// All layers of one picture in one OpenEXR file, as numbers, with camera, frame and colour space in its
/// header.
/// @param index  of frames.shown @param parts  the layer cluster; empty where it is not asked for
void write_layers(const std::string& path, const VoxelModel& model, const Rendered& r, const Image& parts,
                  const std::vector<std::string>& names, const RenderFrames& frames, std::size_t index,
                  double fps);

}  // namespace splinevox::cli
