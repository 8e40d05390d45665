// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "data/pictures/picture_header.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox::data {

/// Pixels of a file: of whole numbers, or of floats. The other one is empty.
struct FilePixels {
  Image16 whole;
  Image real;                  ///< 4 channels, straight alpha
  bool premultiplied = false;  ///< in the file colours were times alpha
};

/// The first picture of a TIFF (6.0, not BigTIFF): grey or RGB with or without alpha, 8 or 16 bits, half or
/// float, in strips or tiles, plain, LZW, Deflate or PackBits, with predictors. What else there is, is
/// refused by name. Extra channels that are not said to be alpha are left out. Limits are those of
/// read_png_header. Throws Error (Fault::input).
/// @{
PictureHeader tiff_header(const std::filesystem::path& path, const std::string& where);
FilePixels read_tiff(const std::filesystem::path& path, const std::string& where);
/// @}

}  // namespace splinevox::data
