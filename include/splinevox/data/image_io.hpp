// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/core/pixel_mask.hpp"

namespace splinevox {

/// What a PNG says about itself before anything is decoded.
struct PngHeader {
  int width = 0, height = 0;  ///< pixels, each in [1, 65536]
  int bits = 0;               ///< per sample: 1, 2, 4, 8 or 16
  int samples = 0;            ///< per pixel as stored: 1 (grey, palette), 2, 3 or 4
  bool alpha = false;         ///< one of these is alpha, or a tRNS chunk makes colours transparent
};

/// Reads and checks the first bytes of a PNG and looks through its first chunks for tRNS, without allocating
/// for what they claim.
/// Refuses more than 65536 pixels a side, more than 2^28 pixels in all, and a picture that could not have
/// been deflated into a file of this size (deflate packs at most 1032 to 1).
/// @param where  how an error names the file; empty = its path.
/// Throws Error (Fault::input).
PngHeader read_png_header(const std::filesystem::path& path, const std::string& where = "");

/// Reads a PNG of any kind (grey, RGB, palette, with or without alpha, 1 to 16 bit, interlaced or not) as
/// straight RGBA, 65535 = 1. Never premultiplies, never applies gamma or a colour profile: values are those
/// stored. Refuses a file that ends early or whose checksums do not match; no partial picture.
/// Throws Error (Fault::input).
Image16 read_png(const std::filesystem::path& path, const std::string& where = "");

/// Reads a JPEG (baseline or progressive; grey, YCbCr or RGB) as opaque RGBA, values as decoded, no colour
/// profile, no rotation that EXIF may ask for: cameras are those of the stored pixels. The limits are those
/// of read_png_header; a file with more than 100 scans, that ends early or is damaged is refused. Throws
/// Error (Fault::input).
Image16 read_jpeg(const std::filesystem::path& path, const std::string& where = "");

struct PictureSize {
  int width = 0, height = 0;
  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

/// Size and pixels of a PNG, JPEG, OpenEXR or TIFF, told apart by their first bytes whatever they are called.
/// Floats are clamped to [0, 1]. Throws Error (Fault::input).
/// @{
PictureSize read_picture_size(const std::filesystem::path& path, const std::string& where = "");
Image16 read_picture(const std::filesystem::path& path, const std::string& where = "");
/// @}

/// What the colour of a block is: the mean of its pixels' colours, all alike, or each by its alpha, so that
/// what is invisible lends no colour. Alpha itself is the mean of all.
enum class ColourMean { plain, by_alpha };

/// Averages blocks of factor x factor pixels, rounded to the nearest 1/65535. Plain means take each of the
/// four channels for itself: straight alpha stays straight, as D-NeRF's own evaluation does it.
/// @pre factor >= 1 divides width and height; load_dataset checks.
Image16 area_downscale(Image16 image, int factor, ColourMean mean = ColourMean::plain);
/// The pixels of such a picture in whose block any pixel is set.
PixelMask area_downscale(const PixelMask& mask, int factor);
/// The same of floats, and of a picture as it is kept. By alpha: @pre there are four channels
/// @{
Image area_downscale(Image image, int factor, ColourMean mean = ColourMean::plain);
Picture area_downscale(const Picture& picture, int factor);
/// @}
/// The camera of a picture that was averaged so.
Camera area_downscale(Camera camera, int factor);

/// The picture as PNG, 8 bit a channel: 1 (grey), 3 (RGB) or 4 (straight RGBA) channels; values are clamped
/// to [0, 1] and rounded to the nearest of 0..255; NaN becomes 0. Throws Error (Fault::output) for any other
/// picture.
std::vector<char> encode_png(const Image& image);

/// The same to a file, all or nothing. Throws Error (Fault::output) naming the path.
void write_png(const std::string& path, const Image& image);

}  // namespace splinevox
