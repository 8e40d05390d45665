// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "math/inverse_warp.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

std::vector<Vec3> points_inside(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-0.3f, 0.3f);
  std::vector<Vec3> out(count);
  for (Vec3& p : out) p = {uniform(random), uniform(random), uniform(random)};
  return out;
}

struct Linear {
  Vec3d displacement, gradient[3];
};

}  // namespace

TEST_SUITE("math/inverse_warp") {
  TEST_CASE("an affine warp is inverted in one step, to rounding") {
    const Vec3d rows[3] = {{0.2, -0.4, 0.1}, {0.3, 0.1, -0.2}, {0, 0.5, -0.3}};
    const auto warp = [&](const Vec3d& x) {
      return Linear{{dot(rows[0], x) + 1, dot(rows[1], x), dot(rows[2], x) - 2}, {rows[0], rows[1], rows[2]}};
    };
    const Vec3d x{0.3, -0.7, 1.1};
    const auto found = invert_warp(warp, x + warp(x).displacement, {0, 0, 0}, 1e-14);
    CHECK(found.residual <= 1e-14);
    CHECK(length(found.x - x) < 1e-13);
    CHECK(found.converged);
    CHECK_FALSE(found.folded);
  }
  TEST_CASE("the kink of a trilinear field is crossed: no walking in circles") {
    // Displacement -0.9 |x|: slopes 0.1 and 1.9 to either side of 0.
    const auto warp = [](const Vec3d& x) {
      const double s = x.x < 0 ? 0.9 : -0.9;
      return Linear{{s * x.x, 0, 0}, {{s, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
    };
    for (const double start : {-3.0, -0.01, 0.01, 50.0}) {
      const auto found = invert_warp(warp, {-1.9, 0, 0}, {start, 0, 0}, 1e-12);
      CHECK(found.converged);
      CHECK(found.x.x == doctest::Approx(-1));
    }
  }
  TEST_CASE("a place the warp does not reach: the nearest it comes to, not converged, finite") {
    const auto warp = [](const Vec3d& x) {
      return Linear{{x.x * x.x - x.x, 0, 0}, {{2 * x.x - 1, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
    };  // x' = x^2
    const auto found = invert_warp(warp, {-1, 0, 0}, {3, 0, 0}, 1e-9);
    CHECK_FALSE(found.converged);
    CHECK(found.residual == doctest::Approx(1).epsilon(1e-2));
    CHECK(std::isfinite(found.x.x));
  }
}

TEST_SUITE("field/track") {
  TEST_CASE("points follow a motion that turns and stretches, both ways in time, and come back") {
    BlobMotion motion;
    motion.shift = {-0.2f, 0.1f, 0.05f};
    motion.twist = 0.4f;
    const VoxelModel model = blob_model(32, motion);
    const std::vector<Vec3> points = points_inside(200);
    const std::vector<double> times{0.9, 0.0, 0.4, 1.0};
    const auto tracked = track(model, points, 0.4, times);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const FrameSampler start(model, 0.4), end(model, times[k]);
      for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK_FALSE(tracked[k][i].folded);
        CHECK(length(end.canonical(tracked[k][i].position) - start.canonical(points[i])) <=
              0.02f * model.step);
      }
    }
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(tracked[2][i].position == points[i]);
    std::vector<Vec3> there;
    for (const TrackedPoint& p : tracked[3]) there.push_back(p.position);
    const auto back = track(model, there, 1.0, std::vector<double>{0.4});
    for (std::size_t i = 0; i < points.size(); ++i)
      CHECK(length(back[0][i].position - points[i]) < 0.1f * model.step);
  }
  TEST_CASE(
      "a translation is followed exactly; without motion nothing moves; times beyond the ends are the ends") {
    BlobMotion motion;
    motion.shift = {-0.5f, 0.1f, 0.2f};
    const std::vector<Vec3> points = points_inside(50);
    const auto moved = track(blob_model(32, motion), points, -3, std::vector<double>{0.5, 7});
    for (std::size_t i = 0; i < points.size(); ++i) {
      CHECK(length(moved[0][i].position - (points[i] - 0.5f * motion.shift)) < 1e-5f);
      CHECK(length(moved[1][i].position - (points[i] - motion.shift)) < 1e-5f);
    }
    motion.moves = false;
    const auto still = track(blob_model(32, motion), points, 0, std::vector<double>{1});
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(still[0][i].position == points[i]);
  }
  TEST_CASE("a track that begins where space is turned inside out is flagged") {
    BlobMotion motion;
    motion.shift = {};
    motion.twist = -4;  // z is scaled by -0.2 at t = 1
    const auto tracked = track(blob_model(32, motion), points_inside(50), 1, std::vector<double>{0});
    int folded = 0;
    for (const TrackedPoint& p : tracked[0]) {
      CHECK(std::isfinite(p.position.x));
      folded += p.folded;
    }
    CHECK(folded == 50);
  }
}
