// SPDX-License-Identifier: Apache-2.0
#include "data/camera_check.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "data/expect_error.hpp"
#include "math/camera.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::data;
using splinevox::test::expect_error;
using splinevox::test::orbit_matrix;
using Matrix = std::array<double, 16>;

/// The upper 3 x 3 times `factor`, column by column.
Matrix scaled(Matrix m, double x, double y, double z) {
  for (std::size_t row = 0; row < 3; ++row) {
    m[4 * row] *= x;
    m[4 * row + 1] *= y;
    m[4 * row + 2] *= z;
  }
  return m;
}

Matrix with(std::size_t index, double value) {
  Matrix m = orbit_matrix(0.3);
  m[index] = value;
  return m;
}

void check_orthonormal(const RigidPose& pose) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      CHECK(dot(pose.axes[std::size_t(i)], pose.axes[std::size_t(j)]) ==
            doctest::Approx(i == j ? 1 : 0).epsilon(1e-14));
  CHECK(dot(cross(pose.axes[0], pose.axes[1]), pose.axes[2]) == doctest::Approx(1).epsilon(1e-14));
}

TEST_SUITE("data/camera_check") {
  TEST_CASE("a rigid matrix comes through as it is, columns as axes") {
    for (double angle = 0; angle < 6.3; angle += 0.7) {
      CAPTURE(angle);
      const Matrix m = orbit_matrix(angle);
      const RigidPose pose = rigid_pose(m, "here");
      check_orthonormal(pose);
      CHECK(pose.deviation < 1e-14);
      for (int k = 0; k < 3; ++k)
        for (int row = 0; row < 3; ++row)
          CHECK(pose.axes[std::size_t(k)][row] ==
                doctest::Approx(m[std::size_t(4 * row + k)]).epsilon(1e-13));
      CHECK(pose.position == Vec3d{m[3], m[7], m[11]});
    }
  }

  TEST_CASE("a scale or shear within 1e-3 is taken out and its size reported") {
    for (const double s : {1 - 9e-4, 1 - 1e-6, 1 + 1e-5, 1 + 9e-4}) {
      CAPTURE(s);
      const RigidPose pose = rigid_pose(scaled(orbit_matrix(1), s, s, s), "here");
      check_orthonormal(pose);
      CHECK(pose.deviation == doctest::Approx(std::abs(s - 1)).epsilon(1e-6));
      CHECK(pose.position == Vec3d{orbit_matrix(1)[3], orbit_matrix(1)[7], orbit_matrix(1)[11]});
    }
    check_orthonormal(rigid_pose(scaled(orbit_matrix(1), 1.0005, 1, 0.9998), "here"));
  }

  TEST_CASE("what is not rigid is refused, with the reason") {
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
    struct Row {
      Matrix m;
      const char* part;
    };
    const Matrix m = orbit_matrix(0.3);
    const Row rows[] = {
        {with(0, nan), "not finite or too large"},
        {with(3, inf), "not finite or too large"},
        {with(11, -inf), "not finite or too large"},
        {with(7, 1e13), "not finite or too large"},
        {with(12, 0.1), "wrong last row"},
        {with(15, 0), "wrong last row"},
        {with(15, 2), "wrong last row"},
        {scaled(m, 0, 0, 0), "is singular"},
        {scaled(m, 1, 1, 0), "is singular"},
        {scaled(m, 1, 1, 1e-9), "is singular"},
        {scaled(m, 1, 1, -1), "mirrors the camera"},
        {scaled(m, -1, 1, 1), "mirrors the camera"},
        {scaled(m, -1, -1, -1), "mirrors the camera"},
        {scaled(m, -2, 2, 2), "mirrors the camera"},
        {scaled(m, 1, 1, 1.002), "shear or uneven scale"},
        {scaled(m, 0.5, 1, 1), "shear or uneven scale"},
        {with(1, 0.9), "shear or uneven scale"},
        {scaled(m, 1.002, 1.002, 1.002), "has a scale"},
        {scaled(m, 0.33, 0.33, 0.33), "got:      scale 0.33"},
        {scaled(m, 1e6, 1e6, 1e6), "got:      scale 1000000"},
        {scaled(m, 1e-6, 1e-6, 1e-6), "got:      scale 1e-06"},
    };
    for (const Row& row : rows) {
      CAPTURE(row.part);
      expect_error([&] { rigid_pose(row.m, "scene/a.json, frame 4"); },
                   {"scene/a.json, frame 4: 'transform_matrix' ", row.part, "expected:", "got:"});
    }
  }

  TEST_CASE("a mirrored camera gets the hint about axes") {
    expect_error([] { rigid_pose(scaled(orbit_matrix(0), 1, -1, 1), "here"); },
                 {"determinant -1", "try:      flip one axis"});
  }

  TEST_CASE("a transposed matrix is told from the last row") {
    const Matrix m = orbit_matrix(0.3);
    Matrix t{};
    for (std::size_t i = 0; i < 16; ++i) t[i] = m[4 * (i % 4) + i / 4];
    expect_error([&] { rigid_pose(t, "here"); }, {"wrong last row", "not transposed"});
  }

  TEST_CASE("the field of view gives the focal length; the centre defaults to the middle") {
    Lens lens;
    lens.camera_angle_x = std::numbers::pi / 2;
    const Camera camera = pinhole(lens, rigid_pose(orbit_matrix(0), ""), 400, 300, "here");
    CHECK(camera.fx == doctest::Approx(200));
    CHECK(camera.fy == camera.fx);
    CHECK(camera.cx == 200);
    CHECK(camera.cy == 150);
    const Ray edge = camera_ray(camera, 400, 150);
    CHECK(dot(edge.direction, -camera.axes[2]) == doctest::Approx(std::sqrt(0.5)));
  }

  TEST_CASE("fl_x beats the angle; what is given for y is used") {
    Lens lens;
    lens.camera_angle_x = 0.5;
    lens.fl_x = 123;
    CHECK(pinhole(lens, {}, 10, 10, "").fx == 123);
    CHECK(pinhole(lens, {}, 10, 10, "").fy == 123);
    lens.fl_y = 99;
    lens.cx = 4;
    lens.cy = 6.5;
    const Camera camera = pinhole(lens, {}, 10, 10, "");
    CHECK(camera.fy == 99);
    CHECK(camera.cx == 4);
    CHECK(camera.cy == 6.5);
    Lens angles;
    angles.camera_angle_x = 1.0;
    angles.camera_angle_y = std::numbers::pi / 2;
    CHECK(pinhole(angles, {}, 10, 20, "").fy == doctest::Approx(10));
  }

  TEST_CASE("a frame's own lens beats the file's, field by field; its angle beats the file's focal length") {
    Lens file, frame;
    file.fl_x = 50;
    file.fl_y = 51;
    file.cx = 5;
    CHECK(merge(file, frame).fl_y == 51);
    frame.cy = 7;
    CHECK(merge(file, frame).cx == 5);
    CHECK(merge(file, frame).cy == 7);
    frame.camera_angle_x = 0.7;
    CHECK_FALSE(merge(file, frame).fl_x.has_value());
    CHECK(merge(file, frame).camera_angle_x == 0.7);
    frame.fl_x = 60;
    CHECK(merge(file, frame).fl_x == 60);
    CHECK_FALSE(merge(file, frame).fl_y.has_value());
  }

  TEST_CASE("a lens that cannot be is refused") {
    const auto refuse = [](std::optional<double> Lens::*field, double value,
                           const std::vector<std::string>& parts) {
      CAPTURE(value);
      Lens lens;
      if (field != &Lens::camera_angle_x) lens.fl_x = 20;
      lens.*field = value;
      expect_error([&] { pinhole(lens, {}, 20, 20, "scene/a.json, frame 4"); }, parts);
    };
    const double nan = std::nan("");
    for (const double angle : {0.0, -0.5, 3.15, nan})
      refuse(&Lens::camera_angle_x, angle,
             {"scene/a.json, frame 4: 'camera_angle_x' is no field of view", "below pi"});
    refuse(&Lens::camera_angle_x, 39.6, {"it looks like degrees"});
    refuse(&Lens::camera_angle_x, 3.14159265358979, {"focal length 'fl_x' is out of range"});
    refuse(&Lens::camera_angle_y, 0, {"'camera_angle_y' is no field of view"});
    for (const double f : {0.0, -5.0, 1e-9, 1e12, nan})
      refuse(&Lens::fl_x, f, {"focal length 'fl_x' is out of range"});
    refuse(&Lens::fl_y, 0, {"focal length 'fl_y' is out of range"});
    refuse(&Lens::cx, 1e5, {"the centre 'cx' is far outside the picture"});
    refuse(&Lens::cy, nan, {"the centre 'cy' is far outside the picture"});
    refuse(&Lens::w, 800,
           {"'w' is not the picture's size", "expected: 20, as in the image file", "got:      800"});
    refuse(&Lens::h, 10, {"'h' is not the picture's size"});
    expect_error([] { pinhole({}, {}, 20, 20, "here"); },
                 {"there is no focal length", "'camera_angle_x'", "'fl_x'"});
  }
}

}  // namespace
