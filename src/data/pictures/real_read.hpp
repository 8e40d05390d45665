// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "data/pictures/picture_header.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox::data {

/// Pictures of OpenEXR files: colours of the layer that is named, else of the picture itself, else of the one
/// layer that has any (Blender's "Combined" before others). Straight alpha: what is stored is premultiplied.
/// Grey is repeated. Throw Error (Fault::input) by `where`.
/// @{
PictureHeader exr_picture_header(const std::filesystem::path& path, const std::string& where,
                                 const std::string& layer);
Image read_exr_picture(const std::filesystem::path& path, const std::string& where, const std::string& layer);
/// @}

}  // namespace splinevox::data
