// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <limits>
#include <random>

#include "math/camera.hpp"

namespace {

using namespace splinevox;

constexpr double kUnit = std::numeric_limits<double>::epsilon();

Distortion lens_of(Distortion::Kind kind, std::array<double, 4> k, std::array<double, 2> p = {}) {
  Distortion d{kind, k, p, 0};
  d.reach = lens_reach(d);
  return d;
}

const Distortion kMild = lens_of(Distortion::Kind::brown, {-0.12, 0.03, -0.004, 0.001}, {0.002, -0.003});
const Distortion kBarrel = lens_of(Distortion::Kind::brown, {-0.35, 0.12, 0, 0}, {0.001, 0.0005});
const Distortion kPillow = lens_of(Distortion::Kind::brown, {0.2, 0.05, 0, 0});
const Distortion kFish = lens_of(Distortion::Kind::fisheye, {0.05, -0.02, 0.004, -0.001});

Camera camera_with(const Distortion& lens) {
  Camera c{640, 480, 400, 410, 315, 245, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}, {}};
  c.lens = lens;
  return c;
}

TEST_SUITE("math/lens") {
  TEST_CASE("undistort goes back along distort, to a few roundings") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(-0.8, 0.8);
    for (const Distortion& lens : {kMild, kBarrel, kPillow, kFish}) {
      double worst = 0;
      for (int i = 0; i < 20000; ++i) {
        const LensPoint p{coordinate(random), coordinate(random)};
        const LensPoint d = distort(lens, p);
        const LensRay ray = undistort(lens, d);
        worst = std::max(worst, std::hypot(ray.x / ray.z - p.x, ray.y / ray.z - p.y));
      }
      CAPTURE(int(lens.kind));
      CAPTURE(lens.k[0]);
      CHECK(worst / kUnit < 32);  // the barrel grows by a factor of 4 at the corner
    }
  }

  TEST_CASE("the formulas in more digits") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> coordinate(-0.8, 0.8);
    double brown = 0, fisheye = 0;
    for (int i = 0; i < 20000; ++i) {
      const LensPoint p{coordinate(random), coordinate(random)};
      const long double x = p.x, y = p.y, q = x * x + y * y;
      const auto& k = kMild.k;
      const long double f = 1 + k[0] * q + k[1] * q * q + k[2] * q * q * q + k[3] * q * q * q * q;
      const LensPoint a = distort(kMild, p);
      brown = std::max(
          brown, double(std::abs(a.x - (x * f + 2 * kMild.p[0] * x * y + kMild.p[1] * (q + 2 * x * x)))));
      brown = std::max(
          brown, double(std::abs(a.y - (y * f + kMild.p[0] * (q + 2 * y * y) + 2 * kMild.p[1] * x * y))));
      const long double r = std::sqrt(q), angle = std::atan(r), s = angle * angle;
      const auto& e = kFish.k;
      const long double bent =
          angle * (1 + e[0] * s + e[1] * s * s + e[2] * s * s * s + e[3] * s * s * s * s);
      fisheye = std::max(fisheye, double(std::abs(distort(kFish, p).x - bent / r * x)));
    }
    CHECK(brown / kUnit < 4);
    CHECK(fisheye / kUnit < 4);
  }

  TEST_CASE("a lens without coefficients is a pinhole, to the last bit where it has no kind") {
    Camera plain = camera_with({}), zero = camera_with(lens_of(Distortion::Kind::brown, {}));
    for (int y = 0; y <= 480; y += 60)
      for (int x = 0; x <= 640; x += 64) {
        const Ray a = camera_ray(plain, x, y), b = camera_ray(zero, x, y);
        CHECK(length(a.direction - b.direction) < 4 * kUnit);
        const Projection p = project(plain, a.direction), q = project(zero, a.direction);
        CHECK(std::hypot(p.u - q.u, p.v - q.v) < 1e-12 * 640);
      }
  }

  TEST_CASE("what lies far aside never comes back into the picture") {
    for (const Distortion& lens :
         {kMild, kBarrel, kPillow, kFish, lens_of(Distortion::Kind::brown, {-0.4, 0, 0, 0})}) {
      const Camera camera = camera_with(lens);
      double before = 0;
      for (double r = 0; r < 1000; r = r * 1.05 + 0.001) {
        const Projection p = project(camera, {0.6 * r, -0.8 * r, -1});
        const double from_centre = std::hypot((p.u - camera.cx) / camera.fx, (p.v - camera.cy) / camera.fy);
        CHECK(from_centre >= before);
        before = from_centre;
      }
      CHECK(before > 0.8);
    }
  }

  TEST_CASE("where a lens folds over") {
    CHECK(lens_reach({Distortion::Kind::brown, {-0.4, 0, 0, 0}, {}, 0}) ==
          doctest::Approx(std::sqrt(1 / 1.2)).epsilon(0.02));
    CHECK(kPillow.reach == 20);
    CHECK(lens_growth(kBarrel, 0.99 * kBarrel.reach) > 0);
    CHECK(lens_reach({Distortion::Kind::fisheye, {}, {}, 0}) == doctest::Approx(1.5707963));
  }

  TEST_CASE("rays of a bent lens have unit length and meet the axis at the centre") {
    for (const Distortion& lens : {kMild, kFish}) {
      const Camera camera = camera_with(lens);
      CHECK(length(camera_ray(camera, 315, 245).direction - Vec3d{0, 0, -1}) < 4 * kUnit);
      for (int x = 0; x <= 640; x += 32)
        CHECK(std::abs(length(camera_ray(camera, x, 100).direction) - 1) < 4 * kUnit);
      CHECK(camera_ray(camera, 400, 245).direction.x > 0);
      CHECK(camera_ray(camera, 315, 100).direction.y > 0);
    }
  }
}

}  // namespace
