// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// How a lens bends the pinhole picture; dimensionless, so the same at every picture size. OpenCV's
/// models; `lens_reach` gives the reach.
struct Distortion {
  enum class Kind { none, brown, fisheye };
  Kind kind = Kind::none;
  std::array<double, 4> k{};  ///< radial k1 to k4
  std::array<double, 2> p{};  ///< tangential p1, p2; brown alone has them
  double reach = 0;  ///< the formulas hold up to here and are continued in proportion: tangent of the angle
                     ///< to the axis, for fisheye the angle. Above 0 where `kind` is not none
  friend bool operator==(const Distortion&, const Distortion&) = default;
};
/// The largest `reach` of a lens: up to where it folds over, at most 20 (87 degrees off the axis) or a right
/// angle.
double lens_reach(const Distortion& lens);

/// Camera. Pixel (i, j) has its centre at (i + 0.5, j + 0.5), j counted from the top; axes are
/// OpenGL's: x right, y up, looking along -z.
struct Camera {
  int width = 0, height = 0;              ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::array<Vec3d, 3> axes{};            ///< world directions of camera x, y, z: orthonormal, right-handed
  Vec3d position{};                       ///< world, scene units
  Distortion lens{};
};

/// Half line origin + s * direction, s >= 0 in scene units; direction has unit length.
struct Ray {
  Vec3d origin, direction;
};

/// Affine map from the data's own time to the model's [0, 1]: t = (raw - origin) * scale.
/// Always the train split's; scale 0 means that all training frames share one time.
struct TimeMap {
  double origin = 0, scale = 1;
  double operator()(double raw) const { return (raw - origin) * scale; }
  /// The inverse; where scale is 0 all times are one.
  double raw(double time) const { return scale == 0 ? origin : origin + time / scale; }
  friend bool operator==(const TimeMap&, const TimeMap&) = default;
};

}  // namespace splinevox
