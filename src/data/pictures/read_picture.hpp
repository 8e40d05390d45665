// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "data/pictures/tiff_read.hpp"

namespace splinevox::data {

/// Pixels of a PNG, JPEG, OpenEXR or TIFF, as stored. Throws Error (Fault::input).
FilePixels read_pixels(const std::filesystem::path& path, const std::string& where, const std::string& layer);

}  // namespace splinevox::data
