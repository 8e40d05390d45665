// SPDX-License-Identifier: Apache-2.0
#include "data/camera_check.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "data/message_text.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr double kFarthest = 1e12;   ///< scene units; beyond it rays lose their meaning in double
constexpr double kTolerance = 1e-3;  ///< of scale and shear
constexpr const char* kMatrix = "'transform_matrix' ";

void check_numbers(const std::array<double, 16>& m, const std::string& where) {
  for (std::size_t i = 0; i < 16; ++i)
    if (!(std::abs(m[i]) <= kFarthest))
      fail({where, std::string(kMatrix) + "has a number that is not finite or too large",
            "finite, at most 1e12",
            number(m[i]) + " in row " + std::to_string(i / 4) + ", column " + std::to_string(i % 4), ""});
  const bool zeros = std::abs(m[12]) <= 1e-6 && std::abs(m[13]) <= 1e-6 && std::abs(m[14]) <= 1e-6;
  if (zeros && std::abs(m[15] - 1) <= 1e-6) return;
  fail({where, std::string(kMatrix) + "has a wrong last row", "0 0 0 1",
        number(m[12]) + " " + number(m[13]) + " " + number(m[14]) + " " + number(m[15]),
        zeros ? "its last number is a scale: write 1 in its place, and divide all others by it if they were "
                "multiplied by it (where all frames have the same one, this is done)"
              : "store the camera-to-world matrix by rows, not transposed"});
}

void check_rigid(const Eigen::Vector3d& s, double det, const std::string& where) {
  const std::string got = "singular values " + number(s[0]) + ", " + number(s[1]) + ", " + number(s[2]);
  if (s[2] <= 1e-6 * s[0])
    fail({where, std::string(kMatrix) + "is singular", "a rotation and a position", got, ""});
  if (det < 0)
    fail({where, std::string(kMatrix) + "mirrors the camera", "a rotation (determinant 1)",
          "determinant " + number(det), "flip one axis: x must point right, y up, z backwards (OpenGL)"});
  if (s[0] - s[2] > kTolerance * s[0])
    fail({where, std::string(kMatrix) + "is not rigid (shear or uneven scale)", "a rotation and a position",
          got, ""});
  if (std::abs(s.mean() - 1) > kTolerance)
    fail({where, std::string(kMatrix) + "has a scale", "a rotation and a position, scale 1",
          "scale " + number(s.mean()), "divide its first three columns by " + number(s.mean())});
}

void check_angle(const std::optional<double>& angle, const char* field, const std::string& where) {
  if (!angle || (*angle > 0 && *angle < std::numbers::pi)) return;
  const bool degrees = *angle > std::numbers::pi && *angle < 180;
  fail({where, std::string("'") + field + "' is no field of view", "radians, above 0 and below pi",
        number(*angle), degrees ? "it looks like degrees: multiply by pi / 180" : ""});
}

void check_focal(double f, const char* field, int pixels, const std::string& where) {
  if (f >= 1e-4 * pixels && f <= 1e7 * pixels) return;
  fail({where, std::string("the focal length '") + field + "' is out of range",
        number(1e-4 * pixels) + " to " + number(1e7 * pixels) + " pixels", number(f), ""});
}

void check_size(const std::optional<double>& stated, const char* field, int pixels,
                const std::string& where) {
  if (!stated || *stated == pixels) return;
  fail({where, std::string("'") + field + "' is not the picture's size",
        std::to_string(pixels) + ", as in the image file", number(*stated),
        "give w, h, fl_x, fl_y, cx and cy for the stored pictures"});
}

void check_centre(double c, const char* field, int pixels, const std::string& where) {
  if (std::abs(c) <= 10.0 * pixels) return;
  fail({where, std::string("the centre '") + field + "' is far outside the picture",
        "within 10 picture widths", number(c), ""});
}

/// A lens given for w x h pixels as that of a picture of another size.
Lens scale_lens(Lens lens, int width, int height, const std::string& where) {
  if (!lens.w || !lens.h || *lens.w <= 0 || *lens.h <= 0) return lens;
  const double across = width / *lens.w, down = height / *lens.h;
  if (std::abs(*lens.w * down - width) > 2 && std::abs(*lens.h * across - height) > 2)
    fail({where, "the picture has another shape than its camera",
          number(*lens.w) + " x " + number(*lens.h) + " or the same scaled",
          std::to_string(width) + " x " + std::to_string(height),
          "use the pictures that the cameras were made for"});
  if (across == 1 && down == 1) return lens;
  if (lens.fl_x) lens.fl_y = lens.fl_y.value_or(*lens.fl_x) * down;
  for (auto& value : {&lens.fl_x, &lens.cx})
    if (*value) **value *= across;
  if (lens.cy) *lens.cy *= down;
  lens.w = width;
  lens.h = height;
  return lens;
}

/// The distortion, proved to be undone by rays along the border and the middle of the picture.
void bend(Camera& camera, const Lens& lens, const std::string& where) {
  Distortion& d = camera.lens;
  const bool fisheye = lens.fisheye.value_or(false);
  d.k = {lens.k1.value_or(0), lens.k2.value_or(0), lens.k3.value_or(0), lens.k4.value_or(0)};
  d.p = {lens.p1.value_or(0), lens.p2.value_or(0)};
  for (const double value : {d.k[0], d.k[1], d.k[2], d.k[3], d.p[0], d.p[1]})
    if (!(std::abs(value) <= 1e6))
      fail({where, "a coefficient of the distortion is out of range", "finite, at most 1e6", number(value),
            ""});
  if (fisheye && (d.p[0] != 0 || d.p[1] != 0))
    fail({where, "a fisheye lens has no tangential distortion", "p1 and p2 absent or 0",
          number(d.p[0]) + ", " + number(d.p[1]), ""});
  if (!fisheye && d.k == std::array<double, 4>{} && d.p == std::array<double, 2>{}) return;
  d.kind = fisheye ? Distortion::Kind::fisheye : Distortion::Kind::brown;
  d.reach = lens_reach(d);
  Camera still = camera;
  still.position = {};  // where it stands would cost digits
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; j += i % kSteps == 0 || i == kSteps / 2 ? 1 : kSteps) {
      const double u = camera.width * double(i) / kSteps, v = camera.height * double(j) / kSteps;
      const Projection p = project(still, camera_ray(still, u, v).direction);
      if (p.depth > 0 && std::abs(p.u - u) < 1e-6 && std::abs(p.v - v) < 1e-6) continue;
      fail({where, "the lens distortion cannot be undone in all of the picture",
            "one direction for every pixel", "none at pixel (" + number(u) + ", " + number(v) + ")",
            fisheye
                ? "crop the pictures to less than 180 degrees"
                : "check k1, k2, k3, p1 and p2, or undistort the pictures first (colmap image_undistorter)"});
    }
}

}  // namespace

RigidPose rigid_pose(const std::array<double, 16>& m, const std::string& where) {
  check_numbers(m, where);
  Eigen::Matrix3d a;
  a << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d s =
      svd.info() == Eigen::Success ? Eigen::Vector3d(svd.singularValues()) : Eigen::Vector3d::Zero();
  check_rigid(s, a.determinant(), where);
  const Eigen::Matrix3d r = svd.matrixU() * svd.matrixV().transpose();
  RigidPose pose;
  for (int k = 0; k < 3; ++k) pose.axes[std::size_t(k)] = {r(0, k), r(1, k), r(2, k)};
  pose.position = {m[3], m[7], m[11]};
  pose.deviation = std::max(std::abs(s[0] - 1), std::abs(s[2] - 1));
  return pose;
}

Lens merge(const Lens& file, const Lens& frame) {
  Lens lens = file;
  if (frame.camera_angle_x || frame.fl_x)
    lens.camera_angle_x = lens.camera_angle_y = lens.fl_x = lens.fl_y = {};
  using Field = std::optional<double> Lens::*;
  for (const Field f :
       {&Lens::camera_angle_x, &Lens::camera_angle_y, &Lens::fl_x, &Lens::fl_y, &Lens::cx, &Lens::cy,
        &Lens::w, &Lens::h, &Lens::k1, &Lens::k2, &Lens::k3, &Lens::k4, &Lens::p1, &Lens::p2})
    if (frame.*f) lens.*f = frame.*f;
  if (frame.fisheye) lens.fisheye = frame.fisheye;
  return lens;
}

Camera pinhole(const Lens& stated, const RigidPose& pose, int width, int height, const std::string& where) {
  const Lens lens = stated.scaled ? scale_lens(stated, width, height, where) : stated;
  check_angle(lens.camera_angle_x, "camera_angle_x", where);
  check_angle(lens.camera_angle_y, "camera_angle_y", where);
  if (!lens.fl_x && !lens.camera_angle_x)
    fail({where, "there is no focal length", "'camera_angle_x' (radians) or 'fl_x' (pixels)", "neither", ""});
  if (!lens.scaled) {
    check_size(lens.w, "w", width, where);
    check_size(lens.h, "h", height, where);
  }
  Camera camera{width, height, 0, 0, 0, 0, pose.axes, pose.position, {}};
  camera.fx = lens.fl_x ? *lens.fl_x : focal_of(*lens.camera_angle_x, width);
  const bool by_angle = !lens.fl_y && lens.camera_angle_y;
  camera.fy = lens.fl_y ? *lens.fl_y : by_angle ? focal_of(*lens.camera_angle_y, height) : camera.fx;
  camera.cx = lens.cx.value_or(0.5 * width);
  camera.cy = lens.cy.value_or(0.5 * height);
  check_focal(camera.fx, "fl_x", width, where);
  check_focal(camera.fy, "fl_y", height, where);
  check_centre(camera.cx, "cx", width, where);
  check_centre(camera.cy, "cy", height, where);
  bend(camera, lens, where);
  return camera;
}

}  // namespace splinevox::data
