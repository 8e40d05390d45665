// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/exposure.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox {

/// The neutral target of one pixel over a background, for looks that training takes at its pictures.
inline Vec3 neutral_target(const Picture& picture, int x, int y, const Vec3& behind, const Vec3& gain) {
  const Vec3 display = composite(picture, x, y, behind);
  const auto p = picture.rgba(x, y);
  const bool clipped = !picture.layout().half;
  const float share = p[3] / (65535.0f * 65535.0f);
  Vec3 out;
  for (int c = 0; c < 3; ++c)
    out[c] = neutral_target(display[c], share * p[std::size_t(c)], gain[c], clipped);
  return out;
}

}  // namespace splinevox
