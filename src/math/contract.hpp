// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Space around a box, contracted: with u the position in half edges of the box from its middle, and v the
/// largest of |u_x|, |u_y|, |u_z|, a place outside (v > 1) is at (2 - 1 / v) u / v. Infinity lies on the
/// faces of [-2, 2]^3, and lines from the middle stay lines. (Mip-NeRF 360, Eq. 10, with the norm of a box.)
///
/// What a ray meets there, from the box outwards: where it leaves the box scaled by v = 1 / (1 - s), for s
/// from 0 to 1. What lies before the ray has met the box of that size, or behind the camera, is not met: what
/// surrounds a scene stands behind it.
class OuterRay {
 public:
  OuterRay(const Box& box, const Ray& ray) {
    constexpr float kParallel = 1e-20f;  // a direction that never leaves along its axis
    for (int a = 0; a < 3; ++a) {
      const double middle = 0.5 * (double(box.lo[a]) + box.hi[a]),
                   half = 0.5 * (double(box.hi[a]) - box.lo[a]);
      origin_[a] = float((ray.origin[a] - middle) / half);
      direction_[a] = float(ray.direction[a] / half);
      const float d = std::abs(direction_[a]) < kParallel ? kParallel : direction_[a];
      pace_[a] = std::abs(1 / d);
      start_[a] = origin_[a] / d;
    }
  }
  /// A place that is met, contracted. met: false where none is.
  struct Place {
    Vec3 at;
    bool met;
  };
  /// @param s  in [0, 1)
  Place at(float s) const {
    const float rest = 1 - s, v = 1 / rest;
    float enter = 0, leave = 3e38f;  // as of intersect (math/aabb.hpp), of [-v, v]^3
    for (int a = 0; a < 3; ++a) {
      enter = std::max(enter, -v * pace_[a] - start_[a]);
      leave = std::min(leave, v * pace_[a] - start_[a]);
    }
    return {((1 + s) * rest) * (origin_ + leave * direction_), leave > enter};
  }

 private:
  Vec3 origin_, direction_;  ///< half edges of the box from its middle
  Vec3 pace_, start_;        ///< |1 / direction|, origin / direction
};

}  // namespace splinevox
