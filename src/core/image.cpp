// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/image.hpp"

#include <algorithm>

namespace splinevox {

Image composite(const Image16& picture, Vec3 background) {
  Image out(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < out.pixels(); ++i) {
    const std::uint16_t* p = picture.rgba.data() + 4 * i;
    const float alpha = p[3] / 65535.0f;
    for (int c = 0; c < 3; ++c) out.data[3 * i + c] = p[c] / 65535.0f * alpha + background[c] * (1 - alpha);
  }
  return out;
}

Image clamped(Image picture) {
  for (float& v : picture.data) v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN compares false
  return picture;
}

}  // namespace splinevox
