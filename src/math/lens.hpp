// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "splinevox/core/camera.hpp"

/// Lens distortion as OpenCV defines it (its calib3d documentation, "Detailed Description" and "Fisheye
/// camera model"), with the coefficient of r^8 that nerfstudio adds. x to the right, y down, both over the
/// depth.
namespace splinevox {

/// A place in the picture plane at unit distance.
struct LensPoint {
  double x, y;
};

/// A direction: x right, y down, z forwards; of any length.
struct LensRay {
  double x, y, z;
};

/// 1 + k1 q + k2 q^2 + k3 q^3 + k4 q^4, q the square of a radius or an angle.
SPLINEVOX_HD inline double lens_factor(const Distortion& lens, double q) {
  return 1 + q * (lens.k[0] + q * (lens.k[1] + q * (lens.k[2] + q * lens.k[3])));
}

/// d lens_factor / d q.
SPLINEVOX_HD inline double lens_factor_slope(const Distortion& lens, double q) {
  return lens.k[0] + q * (2 * lens.k[1] + q * (3 * lens.k[2] + q * 4 * lens.k[3]));
}

/// d (r lens_factor(r^2)) / d r: where it falls to 0 the picture folds over.
SPLINEVOX_HD inline double lens_growth(const Distortion& lens, double r) {
  return lens_factor(lens, r * r) + 2 * r * r * lens_factor_slope(lens, r * r);
}

/// The largest `reach` of a lens: up to where it folds over, at most 20 (87 degrees off the axis) or a right
/// angle.
SPLINEVOX_HD inline double lens_reach(const Distortion& lens) {
  const double end = lens.kind == Distortion::Kind::fisheye ? 1.5707963267948966 : 20;
  constexpr int kSteps = 2000;
  for (int i = 1; i <= kSteps; ++i)
    if (!(lens_growth(lens, end * i / kSteps) > 0)) return end * (i - 1) / kSteps;
  return end;
}

/// Where the lens shows what a pinhole would show at p. Beyond `reach` in proportion, so that what lies far
/// aside never comes back into the picture.
SPLINEVOX_HD inline LensPoint distort(const Distortion& lens, LensPoint p) {
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
SPLINEVOX_HD inline LensPoint on_circle(double angle) {
#if defined(__CUDA_ARCH__)
  LensPoint out;
  sincospi(angle * 0.31830988618379067, &out.y, &out.x);
  return out;
#else
  return {std::cos(angle), std::sin(angle)};
#endif
}

/// The direction that the lens shows at d: distort backwards, by Newton's method from d itself. It ends at
/// rounding wherever the lens does not fold over, which the readers check along the border of the picture.
SPLINEVOX_HD inline LensRay undistort(const Distortion& lens, LensPoint d) {
  constexpr int kRounds = 30;
  if (lens.kind == Distortion::Kind::fisheye) {
    const double radius = std::sqrt(d.x * d.x + d.y * d.y);
    if (radius < 1e-12) return {d.x, d.y, 1};
    double angle = std::fmin(radius, lens.reach);
    for (int i = 0; i < kRounds; ++i) {
      const double step = (angle * lens_factor(lens, angle * angle) - radius) / lens_growth(lens, angle);
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

}  // namespace splinevox
