// SPDX-License-Identifier: Apache-2.0
#include "math/camera.hpp"

#include "math/camera_bodies.hpp"

namespace splinevox {

double lens_growth(const Distortion& lens, double r) { return bodies::lens_growth(lens, r); }

double lens_reach(const Distortion& lens) { return bodies::lens_reach(lens); }

LensPoint distort(const Distortion& lens, LensPoint p) { return bodies::distort(lens, p); }

LensRay undistort(const Distortion& lens, LensPoint d) { return bodies::undistort(lens, d); }

Ray camera_ray(const Camera& camera, double u, double v) { return bodies::camera_ray(camera, u, v); }

Projection project(const Camera& camera, const Vec3d& world) {
  const Vec3d d = world - camera.position;
  const double depth = -dot(d, camera.axes[2]);
  if (camera.lens.kind != Distortion::Kind::none) {
    const LensPoint p =
        distort(camera.lens, {dot(d, camera.axes[0]) / depth, -dot(d, camera.axes[1]) / depth});
    return {camera.cx + camera.fx * p.x, camera.cy + camera.fy * p.y, depth};
  }
  return {camera.cx + camera.fx * dot(d, camera.axes[0]) / depth,
          camera.cy - camera.fy * dot(d, camera.axes[1]) / depth, depth};
}

}  // namespace splinevox
