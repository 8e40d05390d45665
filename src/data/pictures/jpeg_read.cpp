// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "data/file_bytes.hpp"
#include "data/pictures/jpeg_decoder.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace {

constexpr std::uint64_t kPackBound =
    4096;  ///< pixels per file byte; an 8 x 8 block takes a bit at the least, arithmetic coding less
constexpr std::uintmax_t kJpegFirstBytes = std::uintmax_t(1) << 15;  ///< enough for nearly every header
constexpr std::uintmax_t kJpegHeaderBytes =
    std::uintmax_t(4) << 20;  ///< previews and colour profiles may stand before the size

PictureSize check_jpeg(data::JpegDecoder& decoder, std::uintmax_t file_size, const std::string& where) {
  if (!decoder.begin())
    fail(
        {where, "the image is truncated or damaged", "a whole JPEG", decoder.error(), "copy the file again"});
  const std::string size = std::to_string(decoder.width()) + " x " + std::to_string(decoder.height());
  const std::uint64_t pixels = std::uint64_t(decoder.width()) * std::uint64_t(decoder.height());
  if (pixels < 1 || pixels > data::kMostPixels)
    fail({where, "the image's size is out of range", "1 to 65500 pixels a side and at most 2^28 in all", size,
          ""});
  if (!decoder.colours_known())
    fail({where, "the JPEG's colours are neither grey nor RGB", "grey, YCbCr or RGB", "CMYK or another",
          "convert it to PNG"});
  if (pixels / kPackBound > file_size)
    fail({where, "the image claims more pixels than its file can hold",
          "a JPEG of " + size + " pixels in full", std::to_string(file_size) + " bytes",
          "copy the file again"});
  return {decoder.width(), decoder.height()};
}

}  // namespace

Image16 read_jpeg(const std::filesystem::path& path, const std::string& where) {
  const std::string name = where.empty() ? path.string() : where;
  const std::vector<std::uint8_t> bytes = data::read_bytes(path, name, data::kLargestFile);
  data::JpegDecoder decoder(bytes);
  const PictureSize size = check_jpeg(decoder, bytes.size(), name);
  std::vector<std::uint8_t> rgb(std::size_t(size.width) * std::size_t(size.height) * 3);
  if (!decoder.read(rgb.data()))
    fail({name, "the image is truncated or damaged", "a whole JPEG", decoder.error(),
          "copy or make the file again"});
  Image16 image{size.width, size.height, {}};
  image.rgba.resize(image.pixels() * 4, 65535);
  for (std::size_t p = 0; p < image.pixels(); ++p)
    for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * p + c] = std::uint16_t(257 * rgb[3 * p + c]);
  return image;
}

data::PictureHeader data::jpeg_header(const std::filesystem::path& path, const std::string& name) {
  const std::uintmax_t size = file_size_of(path, name);
  std::vector<std::uint8_t> bytes = read_bytes(path, name, kLargestFile, kJpegFirstBytes);
  if (bytes.size() < size && !JpegDecoder(bytes).begin())  // a preview or a profile stands before the size
    bytes = read_bytes(path, name, kLargestFile, kJpegHeaderBytes);
  JpegDecoder decoder(bytes);
  const PictureSize stored = check_jpeg(decoder, size, name);
  return {.size = stored, .orientation = exif_orientation(decoder.app1())};
}

}  // namespace splinevox
