// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Pinhole camera. Pixel (i, j) has its centre at (i + 0.5, j + 0.5), j counted from the top; axes are
/// OpenGL's: x right, y up, looking along -z.
struct Camera {
  int width = 0, height = 0;              ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::array<Vec3d, 3> axes{};            ///< world directions of camera x, y, z: orthonormal, right-handed
  Vec3d position{};                       ///< world, scene units
};

/// Affine map from the data's own time to the model's [0, 1]: t = (raw - origin) * scale.
/// Always the train split's; scale 0 means that all training frames share one time.
struct TimeMap {
  double origin = 0, scale = 1;
  double operator()(double raw) const { return (raw - origin) * scale; }
  friend bool operator==(const TimeMap&, const TimeMap&) = default;
};

}  // namespace splinevox
