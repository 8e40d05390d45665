// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/image.hpp"

#include <algorithm>

namespace splinevox {

Image composite(const Image16& picture, Vec3 background) {
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
