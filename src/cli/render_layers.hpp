// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/render_frames.hpp"
#include "run/cryptomatte.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::cli {

/// What --layers asks for. Throws Error (input): an unknown name, one that the format has no room for, or two
/// that are the same channels.
std::vector<std::string> chosen_layers(const std::string& text, const std::string& format);

/// The layers of the parts that move alike, which take renderers of their own.
class PartPictures {
 public:
  /// Finds the parts if any of these layers shows them.
  PartPictures(const VoxelModel& model, const std::vector<std::string>& names, Device device);
  /// The layer cluster. @pre it is among the names
  Image picture(const Shot& shot, const RenderOptions& options);
  /// The layer crypto. @pre it is among the names
  PartMattes& mattes() { return *mattes_; }

 private:
  std::unique_ptr<const VoxelModel> painted_;
  std::optional<Renderer> renderer_;
  std::optional<PartMattes> mattes_;
};

/// Whether pictures for these layers must show nothing behind the model (nothing_behind).
bool wants_nothing_behind(const std::vector<std::string>& names);

/// All layers of one picture in one OpenEXR file, as numbers, with camera, frame and colour space in its
/// header.
/// @param index  of frames.shown
void write_layers(const std::string& path, const VoxelModel& model, const Rendered& r, PartPictures& parts,
                  const std::vector<std::string>& names, const RenderFrames& frames, std::size_t index,
                  double fps, const RenderOptions& options);

}  // namespace splinevox::cli
