// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/camera.hpp"
#include "splinevox/math/lens.hpp"

namespace splinevox {

/// Half line origin + s * direction, s >= 0 in scene units; direction has unit length.
struct Ray {
  Vec3d origin, direction;
};

/// The ray through image position (u, v) in pixels, v downwards; pixel (i, j) has its centre at
/// (i + 0.5, j + 0.5). In double: the origin may lie far from the box (numerics H14).
inline Ray camera_ray(const Camera& camera, double u, double v) {
  if (camera.lens.kind != Distortion::Kind::none) {
    const LensRay ray = undistort(camera.lens, {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
    return {camera.position, normalize(ray.x * camera.axes[0] - ray.y * camera.axes[1] - ray.z * camera.axes[2])};
  }
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
  if (camera.lens.kind != Distortion::Kind::none) {
    const LensPoint p = distort(camera.lens, {dot(d, camera.axes[0]) / depth, -dot(d, camera.axes[1]) / depth});
    return {camera.cx + camera.fx * p.x, camera.cy + camera.fy * p.y, depth};
  }
  return {camera.cx + camera.fx * dot(d, camera.axes[0]) / depth,
          camera.cy - camera.fy * dot(d, camera.axes[1]) / depth, depth};
}

}  // namespace splinevox
