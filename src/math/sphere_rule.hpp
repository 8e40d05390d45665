// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

struct SpherePoint {
  Vec3d direction;  ///< unit length
  double weight;    ///< all add up to 1
};

/// Lebedev's rule of 26 points for means over the sphere, exact to degree 7: the middles of the faces, edges
/// and corners of a cube.
inline std::array<SpherePoint, 26> sphere_rule() {
  constexpr double kWeight[4] = {0, 1.0 / 21, 4.0 / 105, 9.0 / 280};
  std::array<SpherePoint, 26> points;
  std::size_t n = 0;
  for (int i = 0; i < 27; ++i) {
    const Vec3d d{double(i / 9 - 1), double(i / 3 % 3 - 1), double(i % 3 - 1)};
    const int kind = int(dot(d, d));
    if (kind > 0) points[n++] = {normalize(d), kWeight[kind]};
  }
  return points;
}

}  // namespace splinevox
