// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/hd.hpp"
#include "math/lens.hpp"

/// What math/lens.hpp and math/camera.hpp declare, for camera.cpp and for kernels, which cannot call it.
/// Always in line: a copy of its own in every object would leave it to the linker whose instructions, and
/// last bits, a program gets.
namespace splinevox::bodies {

/// 1 + k1 q + k2 q^2 + k3 q^3 + k4 q^4, q the square of a radius or an angle.
SPLINEVOX_INLINE double lens_factor(const Distortion& lens, double q) {
  return 1 + q * (lens.k[0] + q * (lens.k[1] + q * (lens.k[2] + q * lens.k[3])));
}

/// d lens_factor / d q.
SPLINEVOX_INLINE double lens_factor_slope(const Distortion& lens, double q) {
  return lens.k[0] + q * (2 * lens.k[1] + q * (3 * lens.k[2] + q * 4 * lens.k[3]));
}

SPLINEVOX_INLINE double lens_growth(const Distortion& lens, double r) {
  return lens_factor(lens, r * r) + 2 * r * r * lens_factor_slope(lens, r * r);
}

SPLINEVOX_INLINE double lens_reach(const Distortion& lens) {
  const double end = lens.kind == Distortion::Kind::fisheye ? 1.5707963267948966 : 20;
  constexpr int kSteps = 2000;
  for (int i = 1; i <= kSteps; ++i)
    if (!(bodies::lens_growth(lens, end * i / kSteps) > 0)) return end * (i - 1) / kSteps;
  return end;
}

SPLINEVOX_INLINE LensPoint distort(const Distortion& lens, LensPoint p) {
  const double r = std::sqrt(p.x * p.x + p.y * p.y);
  if (lens.kind == Distortion::Kind::fisheye) {
    const double angle = std::atan(r), held = std::fmin(angle, lens.reach);
    const double share = r > 1e-12 ? angle * lens_factor(lens, held * held) / r : 1;
    return {share * p.x, share * p.y};
  }
  const double beyond = r > lens.reach ? r / lens.reach : 1;
  const double x = p.x / beyond, y = p.y / beyond, q = x * x + y * y, f = lens_factor(lens, q);
  return {beyond * (x * f + 2 * lens.p[0] * x * y + lens.p[1] * (q + 2 * x * x)),
          beyond * (y * f + lens.p[0] * (q + 2 * y * y) + 2 * lens.p[1] * x * y)};
}

/// Cosine and sine of an angle of at most a right one. What a device does for larger ones needs an array in
/// its slow memory.
SPLINEVOX_INLINE LensPoint on_circle(double angle) {
#if defined(__CUDA_ARCH__)
  LensPoint out;
  sincospi(angle * 0.31830988618379067, &out.y, &out.x);
  return out;
#else
  return {std::cos(angle), std::sin(angle)};
#endif
}

SPLINEVOX_INLINE LensRay undistort(const Distortion& lens, LensPoint d) {
  constexpr int kRounds = 30;
  if (lens.kind == Distortion::Kind::fisheye) {
    const double radius = std::sqrt(d.x * d.x + d.y * d.y);
    if (radius < 1e-12) return {d.x, d.y, 1};
    double angle = std::fmin(radius, lens.reach);
    for (int i = 0; i < kRounds; ++i) {
      const double step =
          (angle * lens_factor(lens, angle * angle) - radius) / bodies::lens_growth(lens, angle);
      angle = std::fmin(std::fmax(angle - step, 0.0), lens.reach);
      if (!(std::abs(step) > 1e-15)) break;
    }
    const LensPoint turned = on_circle(angle);
    const double s = turned.y / radius;
    return {s * d.x, s * d.y, turned.x};
  }
  double x = d.x, y = d.y;
  for (int i = 0; i < kRounds; ++i) {
    if (const double r = std::sqrt(x * x + y * y); r > lens.reach) {
      x *= lens.reach / r;
      y *= lens.reach / r;
    }
    const double q = x * x + y * y, f = lens_factor(lens, q), slope = 2 * lens_factor_slope(lens, q);
    const double p1 = lens.p[0], p2 = lens.p[1];
    const double ex = x * f + 2 * p1 * x * y + p2 * (q + 2 * x * x) - d.x;
    const double ey = y * f + p1 * (q + 2 * y * y) + 2 * p2 * x * y - d.y;
    const double xx = f + x * x * slope + 2 * p1 * y + 6 * p2 * x,
                 yy = f + y * y * slope + 6 * p1 * y + 2 * p2 * x;
    const double xy = x * y * slope + 2 * p1 * x + 2 * p2 * y, det = xx * yy - xy * xy;
    const double sx = (yy * ex - xy * ey) / det, sy = (xx * ey - xy * ex) / det;
    x -= sx;
    y -= sy;
    if (!(std::abs(sx) + std::abs(sy) > 1e-15 * (1 + std::abs(x) + std::abs(y)))) break;
  }
  return {x, y, 1};
}

SPLINEVOX_INLINE Ray camera_ray(const Camera& camera, double u, double v) {
  const auto& [right, up, back] = camera.axes;
  double x = (u - camera.cx) / camera.fx, y = -(v - camera.cy) / camera.fy;
  Vec3d d;
  if (camera.lens.kind == Distortion::Kind::none) {
    d = {std::fma(y, up.x, x * right.x) - back.x, std::fma(x, right.y, y * up.y) - back.y,
         std::fma(x, right.z, y * up.z) - back.z};
  } else {
    const LensRay ray = bodies::undistort(camera.lens, {x, -y});
    d = ray.x * right - ray.y * up - ray.z * back;
  }
  const double scale = 1 / std::sqrt(std::fma(d.z, d.z, std::fma(d.x, d.x, d.y * d.y)));
  return {camera.position, {d.x * scale, d.y * scale, d.z * scale}};
}

}  // namespace splinevox::bodies
