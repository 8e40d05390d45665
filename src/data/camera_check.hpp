// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "splinevox/core/camera.hpp"

namespace splinevox::data {

/// Where a camera stands: orthonormal, right-handed axes.
struct RigidPose {
  std::array<Vec3d, 3> axes{};  ///< world directions of camera x, y, z
  Vec3d position{};             ///< scene units
  double deviation = 0;         ///< how far the matrix was from rigid: largest |singular value - 1|
};

/// The nearest rigid pose (polar decomposition) of a camera-to-world matrix.
/// @param m      4 x 4, row-major; OpenGL camera axes.
/// @param where  file and frame, for errors.
/// Refuses (Error, Fault::input): a number that is not finite or beyond 1e12, a last row other than 0 0 0 1,
/// a singular or reflected matrix, shear or a scale off 1 by more than 1e-3. (numerics H28)
RigidPose rigid_pose(const std::array<double, 16>& m, const std::string& where);

/// The lens as the file gives it; what is absent is empty.
struct Lens {
  std::optional<double> camera_angle_x, camera_angle_y;  ///< full field of view, radians
  std::optional<double> fl_x, fl_y, cx, cy;              ///< pixels
  std::optional<double> w, h;                            ///< pixels
  std::optional<double> k1, k2, k3, k4, p1, p2;          ///< distortion, core/camera.hpp
  std::optional<bool> fisheye;  ///< the coefficients are those of OpenCV's fisheye model
  bool scaled =
      false;  ///< w x h are those of another size of the same picture: the lens is scaled to the stored one
};

/// A frame's lens: its own fields where it has any, else the file's. A frame's own angle beats the file's
/// focal length.
Lens merge(const Lens& file, const Lens& frame);

/// The camera of a stored picture of width x height pixels. Focal length from fl_x, else from
/// camera_angle_x; fl_y from itself, camera_angle_y or fl_x; centre from cx, cy, else the middle.
/// Refuses (Error, Fault::input): no focal length at all, an angle outside (0, pi), a focal length outside
/// [1e-4, 1e7] picture widths, a centre more than 10 widths away, w or h that is not the picture's (or not of
/// its shape, where scaled), a distortion that cannot be undone somewhere in the picture.
Camera pinhole(const Lens& lens, const RigidPose& pose, int width, int height, const std::string& where);

}  // namespace splinevox::data
