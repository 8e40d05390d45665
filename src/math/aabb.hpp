// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

struct Interval {
  double near = 0, far = -1;  ///< empty where far < near
};

/// A direction below this stays where it starts: over 1e12 scene units it leaves by 1e-278, and 1 / it may
/// overflow.
inline constexpr double kNoDirection = 1e-290;

/// The part s in [0, inf) of the line o + s d inside a box. Along an axis without direction the origin
/// decides; the plain (lo - o) * (1 / d) is 0 * inf = NaN there for an origin on a face, for subnormal d as
/// for 0, and min and max keep or lose the NaN by the order of their arguments (numerics H13).
SPLINEVOX_HD inline Interval intersect(const Box& box, const Vec3d& o, const Vec3d& d) {
  Interval s{0, 1e300};
  for (int a = 0; a < 3; ++a) {
    const double lo = box.lo[a], hi = box.hi[a];
    if (std::abs(d[a]) < kNoDirection) {
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
