// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

struct Interval {
  double near = 0, far = -1;  ///< empty where far < near
};

/// The part s in [0, inf) of the line o + s d inside a box. Directions of exactly 0 are decided by the origin, so no
/// 0 * inf arises (numerics H13).
inline Interval intersect(const Box& box, const Vec3d& o, const Vec3d& d) {
  Interval s{0, 1e300};
  for (int a = 0; a < 3; ++a) {
    const double lo = box.lo[a], hi = box.hi[a];
    if (d[a] == 0) {
      if (o[a] < lo || o[a] > hi) return {};
      continue;
    }
    const double inv = 1 / d[a];
    const double s0 = (lo - o[a]) * inv, s1 = (hi - o[a]) * inv;
    const double enter = s0 < s1 ? s0 : s1, leave = s0 < s1 ? s1 : s0;
    if (enter > s.near) s.near = enter;
    if (leave < s.far) s.far = leave;
  }
  return s;
}

}  // namespace splinevox
