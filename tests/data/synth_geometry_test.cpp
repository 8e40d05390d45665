// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "data/synth/geometry.hpp"
#include "data/synth/scene.hpp"

namespace splinevox::data {
namespace {

struct Draw {
  std::mt19937 rng{11};
  double operator()(double lo, double hi) { return lo + (hi - lo) * double(rng() >> 5) / double(1 << 27); }
  Vec3d vector(double r) { return {(*this)(-r, r), (*this)(-r, r), (*this)(-r, r)}; }
};

std::vector<Arc> bent_arcs() {
  const Place start = shift(0.1, -0.2, 0.05) * rotate(turn_x(0.7) * turn_z(-0.4));
  return arcs_of(start, 0.3, {{1.0, 0.5}, {-1.5, 0}, {0, 0}, {0.8, -1.2}, {2.0, 0.3}});
}

TEST_SUITE("data/synth_geometry") {
  TEST_CASE("turns are right-handed rotations that follow the axes") {
    const double q = M_PI / 2;
    CHECK(length(turn_x(q) * Vec3d{0, 1, 0} - Vec3d{0, 0, 1}) < 1e-15);
    CHECK(length(turn_y(q) * Vec3d{0, 0, 1} - Vec3d{1, 0, 0}) < 1e-15);
    CHECK(length(turn_z(q) * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}) < 1e-15);
    const Place p = shift(1, 2, 3) * rotate(turn_x(0.3) * turn_y(0.5));
    const Vec3d m{0.2, -0.7, 0.4};
    CHECK(length(p.inverse(p * m) - m) < 1e-15);
  }

  TEST_CASE("pieces of a tube join with one frame, keep it orthonormal and keep their length") {
    const std::vector<Arc> arcs = bent_arcs();
    for (std::size_t i = 0; i < arcs.size(); ++i) {
      CAPTURE(i);
      const Turn& e = arcs[i].end.turn;
      CHECK(std::abs(dot(e.x, e.y)) + std::abs(dot(e.y, e.z)) + std::abs(dot(e.x, e.z)) < 1e-14);
      CHECK(length(cross(e.x, e.y) - e.z) < 1e-14);
      if (i > 0) CHECK(length(arcs[i].start.turn.z - arcs[i - 1].end.turn.z) < 1e-14);
      double walked = 0;
      for (int k = 0; k < 1000; ++k)
        walked +=
            length(arcs[i].at(arcs[i].length * (k + 1) / 1000).at - arcs[i].at(arcs[i].length * k / 1000).at);
      CHECK(walked == doctest::Approx(arcs[i].length).epsilon(1e-5));
    }
  }

  TEST_CASE("material and world points of a bent tube are inverse maps near its centre line") {
    const Shape tube = make_tube(
        1.5, [](double) { return 0.1; }, 0.1, 0);
    const Pose pose{{}, {1, 1, 1}, bent_arcs()};
    Draw draw;
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const double angle = draw(0, 2 * M_PI), r = draw(0, 0.12);
      const Vec3d m{r * std::cos(angle), r * std::sin(angle), draw(0, 1.5)};
      worst = std::max(worst, length(material_of(tube, pose, world_of(pose, m)) - m));
    }
    CHECK(worst < 1e-12);
  }

  TEST_CASE("squashed and turned solids: the maps are inverse and a wall point has distance 0") {
    Shape ball = make_ball(0.3);
    ball.flat = {1, 0.8, 1.2};
    const Pose pose{{turn_x(0.4) * turn_z(1.0), {0.1, 0.2, -0.3}}, {1.2, 1.2, 0.7}, {}};
    Draw draw;
    for (int i = 0; i < 50; ++i) {
      const Vec3d m = mul(0.3 * normalize(draw.vector(1)), ball.flat);
      CHECK(length(material_of(ball, pose, world_of(pose, m)) - m) < 1e-14);
      CHECK(std::abs(distance_to(ball, pose, world_of(pose, m))) < 1e-14);
    }
  }

  TEST_CASE("a distance never exceeds the way to any wall point, so a ray cannot step through") {
    const auto radius = [](double s) { return 0.06 + 0.03 * std::sin(6 * s); };
    struct Row {
      const char* name;
      Shape shape;
      Pose pose;
    };
    const Place place{turn_x(0.6) * turn_y(0.3), {0.1, 0, 0.2}};
    const Row rows[] = {{"cone", make_cone(0.2, 0.1, 0.4, {1.2, 0.8, 1}), {place, {1, 1, 1}, {}}},
                        {"box", make_box({0.2, 0.1, 0.3}, 0.05), {place, {1.1, 1.1, 0.8}, {}}},
                        {"disc", make_disc(0.4, 0.1, 0.03), {place, {1, 1, 1}, {}}},
                        {"ball", make_ball(0.3), {place, {1.2, 1.2, 0.6}, {}}},
                        {"tube", make_tube(1.5, radius, 0.09, 0.18), {{}, {1, 1, 1}, bent_arcs()}}};
    for (const Row& r : rows) {
      CAPTURE(r.name);
      Draw draw;
      const Bound bound = bound_of(r.shape, r.pose);
      int steep = 0, outside = 0, missed = 0;
      for (int i = 0; i < 4000; ++i) {
        const Vec3d p = bound.centre + draw.vector(1.2 * bound.radius), q = p + draw.vector(0.05);
        const double fp = distance_to(r.shape, r.pose, p), fq = distance_to(r.shape, r.pose, q);
        if (fp <=
            0) {  // p is inside: no bound from outside may say that it is out of reach, and boxes hold it
          steep += fq > length(q - p);
          const auto [from, to] = inside(bound, r.pose, p - Vec3d{5, 0, 0}, {1, 0, 0});
          outside += !(from <= 5 && 5 <= to);
          missed += !bound.met_by(p - Vec3d{0, 7, 0}, {0, 1, 0});
        }
      }
      CHECK(steep == 0);
      CHECK(outside == 0);
      CHECK(missed == 0);
    }
  }
}

}  // namespace
}  // namespace splinevox::data
