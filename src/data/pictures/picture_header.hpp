// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "splinevox/core/image.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

/// What a picture's file says before any pixel is decoded.
struct PictureHeader {
  PictureSize size;     ///< as stored
  bool alpha = false;   ///< there is a channel for it
  bool deep = false;    ///< more than 8 bits a channel
  bool real = false;    ///< values are floats
  bool linear = false;  ///< the format says that they are of linear light
  int orientation = 1;  ///< EXIF's: how to turn the stored picture to see it upright, 1 to 8; 1 = not at all
};

/// Reads the header of a PNG, JPEG, OpenEXR or TIFF. Throws Error (Fault::input).
/// @param layer  of OpenEXR, see real_read.hpp
PictureHeader read_picture_header(const std::filesystem::path& path, const std::string& where = "",
                                  const std::string& layer = "");

/// The same of a JPEG.
PictureHeader jpeg_header(const std::filesystem::path& path, const std::string& where);

/// The orientation in the EXIF block of a JPEG's APP1 marker; 1 if there is none or it makes no sense.
int exif_orientation(std::span<const std::uint8_t> app1);

/// The size of a picture once it is turned.
PictureSize turned(const PictureSize& stored, int orientation);

/// A picture turned as EXIF's orientation says (Exif 2.32, 4.6.4, tag 0x0112).
Image16 turned(Image16 image, int orientation);

}  // namespace splinevox::data
