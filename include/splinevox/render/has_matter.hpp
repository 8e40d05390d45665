// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Whether a picture shows anything in front of the background at a pixel. Where it has the background's colour, to half of one of 255 levels,
/// a ray passes nothing, or fog of that colour, which costs no picture anything and hides what others show. No more than that: a dark scene
/// over black is there, too.
SPLINEVOX_HD inline bool has_matter(const Vec3& target, const Vec3& background) {
  constexpr float kHalfLevel = 0.5f / 255;
  const Vec3 d = target - background;
  return d.x > kHalfLevel || d.x < -kHalfLevel || d.y > kHalfLevel || d.y < -kHalfLevel || d.z > kHalfLevel || d.z < -kHalfLevel;
}

}  // namespace splinevox
