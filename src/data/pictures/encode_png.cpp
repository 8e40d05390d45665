// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "data/pictures/encode.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

std::uint8_t to_byte(float v) {
  if (!(v > 0)) return 0;  // also NaN
  return v >= 1 ? 255 : std::uint8_t(std::floor(v * 255.0f + 0.5f));
}

}  // namespace

std::vector<char> encode_png_for(const std::string& where, const Image& image) {
  const bool known = image.channels == 1 || image.channels == 3 || image.channels == 4;
  const bool sized = image.width > 0 && image.height > 0 && image.width <= 65535 && image.height <= 65535;
  if (!known || !sized || image.data.size() != image.pixels() * std::size_t(image.channels))
    fail_output({.where = where,
                 .what = "this picture cannot be stored as PNG",
                 .expected = "1, 3 or 4 channels and sides of 1 to 65535 pixels",
                 .got = std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
                        std::to_string(image.channels) + " channels",
                 .hint = {}});
  std::vector<std::uint8_t> bytes(image.data.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = to_byte(image.data[i]);

  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = png_uint_32(image.width);
  png.height = png_uint_32(image.height);
  png.format = image.channels == 1 ? PNG_FORMAT_GRAY : image.channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  std::vector<char> file(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = file.size();
  if (!png_image_write_to_memory(&png, file.data(), &size, 0, bytes.data(), 0, nullptr))
    fail_output(
        {.where = where, .what = "PNG compression failed", .expected = {}, .got = png.message, .hint = {}});
  file.resize(size);
  return file;
}

}  // namespace splinevox
