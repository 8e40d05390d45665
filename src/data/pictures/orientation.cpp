// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "data/pictures/picture_header.hpp"

namespace splinevox::data {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Whole numbers of a TIFF block in its own byte order; 0 beyond its end.
struct Tiff {
  Bytes bytes;
  bool little = false;

  std::uint32_t number(std::size_t at, std::size_t size) const {
    if (at > bytes.size() || bytes.size() - at < size) return 0;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= std::uint32_t(bytes[at + i]) << (8 * (little ? i : size - 1 - i));
    return value;
  }
};

}  // namespace

int exif_orientation(Bytes app1) {
  constexpr std::array<std::uint8_t, 6> kExif = {'E', 'x', 'i', 'f', 0, 0};
  constexpr std::uint32_t kTag = 0x0112;
  if (app1.size() < 14 || !std::equal(kExif.begin(), kExif.end(), app1.begin())) return 1;
  const Tiff tiff{app1.subspan(kExif.size()), app1[kExif.size()] == 'I'};
  const std::size_t directory = tiff.number(4, 4), entries = tiff.number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (tiff.number(entry, 2) != kTag) continue;
    const std::uint32_t value = tiff.number(entry + 8, 2);
    return value >= 1 && value <= 8 ? int(value) : 1;
  }
  return 1;
}

PictureSize turned(const PictureSize& stored, int orientation) {
  return orientation >= 5 ? PictureSize{stored.height, stored.width} : stored;
}

Image16 turned(Image16 image, int orientation) {
  if (orientation == 1) return image;
  const int w = image.width, h = image.height;
  const PictureSize size = turned(PictureSize{w, h}, orientation);
  Image16 out{size.width, size.height, {}};
  out.rgba.resize(image.rgba.size());
  const bool turns = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      int u = turns ? y : x, v = turns ? x : y;  // where the pixel is stored
      if (from_right) u = w - 1 - u;
      if (from_below) v = h - 1 - v;
      const auto from = image.rgba.begin() + 4 * (std::ptrdiff_t(v) * w + u);
      std::copy(from, from + 4, out.rgba.begin() + 4 * (std::ptrdiff_t(y) * size.width + x));
    }
  return out;
}

}  // namespace splinevox::data
