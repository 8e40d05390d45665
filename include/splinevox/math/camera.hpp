// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/camera.hpp"

namespace splinevox {

/// Half line origin + s * direction, s >= 0 in scene units; direction has unit length.
struct Ray {
  Vec3d origin, direction;
};

/// The ray through image position (u, v) in pixels, v downwards; pixel (i, j) has its centre at
/// (i + 0.5, j + 0.5). In double: the origin may lie far from the box (numerics H14).
SPLINEVOX_HD inline Ray camera_ray(const Camera& camera, double u, double v) {
  const double x = (u - camera.cx) / camera.fx, y = -(v - camera.cy) / camera.fy;
  const Vec3d d = x * camera.axes[0] + y * camera.axes[1] - camera.axes[2];
  return {camera.position, normalize(d)};
}

/// Image position of a world point, and its depth along the viewing axis (<= 0: behind the camera).
struct Projection {
  double u, v, depth;
};

inline Projection project(const Camera& camera, const Vec3d& world) {
  const Vec3d d = world - camera.position;
  const double depth = -dot(d, camera.axes[2]);
  return {camera.cx + camera.fx * dot(d, camera.axes[0]) / depth,
          camera.cy - camera.fy * dot(d, camera.axes[1]) / depth, depth};
}

}  // namespace splinevox
