// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/image.hpp"

#include <algorithm>
#include <utility>

namespace splinevox {

Picture::Picture(Image16 image) : width(image.width), height(image.height) {
  constexpr int kSteps = 257;  // of 16 bits in one of 8
  if (std::any_of(image.rgba.begin(), image.rgba.end(), [](std::uint16_t v) { return v % kSteps != 0; })) {
    wide_ = std::move(image.rgba);
    return;
  }
  narrow_.resize(image.rgba.size());
  std::transform(image.rgba.begin(), image.rgba.end(), narrow_.begin(),
                 [](std::uint16_t v) { return std::uint8_t(v / kSteps); });
}

Image16 Picture::unpacked() const {
  Image16 out{width, height, {}};
  if (!has_values()) return out;
  out.rgba.reserve(4 * pixels());
  for (std::size_t i = 0; i < pixels(); ++i)
    for (const std::uint16_t v : pixel(i)) out.rgba.push_back(v);
  return out;
}

Image composite(const Picture& picture, Vec3 background) {
  Image out(picture.width, picture.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Vec3 rgb = composite(picture, x, y, background);
      for (int c = 0; c < 3; ++c) out.pixel(x, y)[c] = rgb[c];
    }
  return out;
}

Image clamped(Image picture) {
  for (float& v : picture.data) v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN compares false
  return picture;
}

}  // namespace splinevox
