// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// d (r lens_factor(r^2)) / d r: where it falls to 0 the picture folds over.
double lens_growth(const Distortion& lens, double r);

/// Where the lens shows what a pinhole would show at p. Beyond `reach` in proportion, so that what lies far
/// aside never comes back into the picture.
LensPoint distort(const Distortion& lens, LensPoint p);

/// The direction that the lens shows at d: distort backwards, by Newton's method from d itself. It ends at
/// rounding wherever the lens does not fold over, which the readers check along the border of the picture.
LensRay undistort(const Distortion& lens, LensPoint d);

}  // namespace splinevox
