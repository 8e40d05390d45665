// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Says how many pictures have a mask, in whatever way: named by the data (RawFrame::mask), beside the
/// picture (dynamic_mask_NAME.png, NAME_mask.png), or in a folder of masks in the data set, beside the
/// picture or its folder (NAME.png, NAME.png.png). Nothing if none has one.
std::optional<std::string> note_on_masks(const std::filesystem::path& folder, const RawScene& scene);

}  // namespace splinevox::data
