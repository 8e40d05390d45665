// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "math/lens.hpp"
#include "splinevox/core/camera.hpp"

namespace splinevox {

/// The ray through image position (u, v) in pixels, v downwards; pixel (i, j) has its centre at
/// (i + 0.5, j + 0.5). In double: the origin may lie far from the box (numerics H14). Where products are
/// fused is written out: left to the compiler it depends on the code around, and the same pixel would have
/// another last bit in every caller.
Ray camera_ray(const Camera& camera, double u, double v);

/// The full field of view along a side of `pixels`, radians, of a lens without distortion; and back.
/// @{
inline double angle_of(double focal, int pixels) { return 2 * std::atan(pixels / (2 * focal)); }
inline double focal_of(double angle, int pixels) { return 0.5 * pixels / std::tan(0.5 * angle); }
/// @}

/// Image position of a world point, and its depth along the viewing axis (<= 0: behind the camera).
struct Projection {
  double u, v, depth;
};

Projection project(const Camera& camera, const Vec3d& world);

/// Whether two pictures are of one pose and one lens, but for what is lost where a program writes numbers.
inline bool stand_alike(const Camera& a, const Camera& b) {
  constexpr double kSame = 1e-5;  // of directions, of the distance to the origin and the scene's unit
  constexpr double kPixels = 1e-3;
  if (a.width != b.width || a.height != b.height || !(a.lens == b.lens)) return false;
  if (length(a.position - b.position) > kSame * (1 + length(a.position))) return false;
  for (std::size_t i = 0; i < 3; ++i)
    if (length(a.axes[i] - b.axes[i]) > kSame) return false;
  return std::abs(a.fx - b.fx) <= kPixels && std::abs(a.fy - b.fy) <= kPixels &&
         std::abs(a.cx - b.cx) <= kPixels && std::abs(a.cy - b.cy) <= kPixels;
}

}  // namespace splinevox
