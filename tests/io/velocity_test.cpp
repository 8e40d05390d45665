// SPDX-License-Identifier: Apache-2.0
#include "math/velocity.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

using namespace splinevox;

namespace {

using Rows = Vec3d[3];

/// Rotation about z by `angle`, minus the identity: grad Delta of x' = R x.
void rotation_gradient(double angle, Rows& g) {
  g[0] = {std::cos(angle) - 1, -std::sin(angle), 0};
  g[1] = {std::sin(angle), std::cos(angle) - 1, 0};
  g[2] = {0, 0, 0};
}

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

TEST_SUITE("math/velocity") {
  TEST_CASE("a translation: x' = x - t u moves at u") {
    const Rows g{};
    const auto v = material_velocity(g, Vec3d{-1, 2, -3});
    CHECK(v.velocity == Vec3d{1, -2, 3});
    CHECK(v.stretch == doctest::Approx(1));
    CHECK_FALSE(v.folded);
  }

  TEST_CASE("a rotation: x' = R(-w t) x turns with w x x, exactly and at any angle") {
    for (const double angle : {0.0, 0.3, 1.5, 3.0}) {
      CAPTURE(angle);
      const double w = 2;
      const Vec3d x{0.7, -0.4, 0.2};
      Rows g;
      rotation_gradient(-angle, g);
      // d/dt R(-w t) x at w t = angle.
      const double c = std::cos(angle), s = std::sin(angle);
      const Vec3d d_dt{w * (-s * x.x + c * x.y), w * (-c * x.x - s * x.y), 0};
      const auto v = material_velocity(g, d_dt);
      CHECK(length(v.velocity - Vec3d{-w * x.y, w * x.x, 0}) < 1e-12);
      CHECK(v.stretch == doctest::Approx(1).epsilon(1e-7));
      CHECK_FALSE(v.folded);
    }
  }

  TEST_CASE("a shear that grows: x' = x - k t y e_x moves at k y e_x, however far it went") {
    for (const double amount : {0.0, 1.0, 4.0}) {
      const double k = 3, y = 0.25;
      const Rows g{{0, -amount, 0}, {0, 0, 0}, {0, 0, 0}};
      const auto v = material_velocity(g, Vec3d{-k * y, 0, 0});
      CHECK(length(v.velocity - Vec3d{k * y, 0, 0}) < 1e-12);
    }
  }

  TEST_CASE("random warps: A v = -b, and the stretch is the smallest singular value") {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> u(-0.45, 0.45);
    int solved = 0;
    for (int i = 0; i < 1000; ++i) {
      Rows g;
      for (Vec3d& row : g) row = {u(random), u(random), u(random)};
      const Vec3d b{u(random), u(random), u(random)};
      const auto v = material_velocity(g, b);
      Vec3d a[3] = {g[0], g[1], g[2]};
      for (int k = 0; k < 3; ++k) a[k][k] += 1;
      // No unit vector is stretched less than `stretch`; a few hundred random ones come close to the least.
      double least = 1e9;
      for (int k = 0; k < 400; ++k) {
        const Vec3d d = normalize(Vec3d{u(random), u(random), u(random)});
        least = std::min(least, length(Vec3d{dot(a[0], d), dot(a[1], d), dot(a[2], d)}));
      }
      CHECK(least >= v.stretch - 1e-7);
      CHECK(least < v.stretch + 0.1);
      if (v.folded) continue;
      ++solved;
      const Vec3d residual = Vec3d{dot(a[0], v.velocity), dot(a[1], v.velocity), dot(a[2], v.velocity)} + b;
      CHECK(length(residual) < 1e-9 * (1 + length(v.velocity)));
    }
    CHECK(solved > 800);
  }

  TEST_CASE("a fold is flagged, finite and bounded; a mirrored warp is flagged too") {
    for (const double s : {0.0, 1e-12, 1e-5, 0.01, 0.025, 0.035, 0.0499}) {
      CAPTURE(s);
      const Rows g{{s - 1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
      const auto v = material_velocity(g, Vec3d{1, 0, 0});
      CHECK(v.folded);
      CHECK(v.stretch == doctest::Approx(s).epsilon(1e-6));
      CHECK(finite(v.velocity));
      CHECK(length(v.velocity) <= 25);
    }
    const Rows collapsed{{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    CHECK(material_velocity(collapsed, Vec3d{1, 1, 1}).velocity == Vec3d{0, 0, 0});
    const Rows mirror{{-2, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    CHECK(material_velocity(mirror, Vec3d{1, 0, 0}).folded);
  }

  TEST_CASE("damping begins where the flag begins, without a jump") {
    const auto speed = [](double s) {
      const Rows g{{s - 1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
      return length(material_velocity(g, Vec3d{1, 0, 0}).velocity);
    };
    CHECK(speed(0.05 + 1e-9) == doctest::Approx(20).epsilon(1e-6));
    CHECK(speed(0.05 - 1e-9) == doctest::Approx(20).epsilon(1e-6));
  }
}
