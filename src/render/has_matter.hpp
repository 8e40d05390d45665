// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/photometric.hpp"

namespace splinevox {

inline constexpr float kHalfLevel = 0.5f / 255;  ///< of a picture of 8 bits

/// Whether a picture shows anything in front of the background at a pixel. Where it has the background's
/// colour, to half of one of 255 levels, a ray passes nothing, or fog of that colour, which costs no loss and
/// hides what is visible elsewhere. No more than that: a dark scene over black is there, too.
/// @param target  a value or a bound (math/photometric.hpp)
/// @param faintest  half a level times the unit of brightness: in a scene a thousandth as bright, levels are
/// a thousandth apart (numerics H30).
SPLINEVOX_HD inline bool has_matter(const Vec3& target, const Vec3& background, float faintest) {
  const Vec3 d = colour_of(target) - background;
  return d.x > faintest || d.x < -faintest || d.y > faintest || d.y < -faintest || d.z > faintest ||
         d.z < -faintest;
}

}  // namespace splinevox
