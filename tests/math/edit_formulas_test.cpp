// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "math/basis_pieces.hpp"
#include "math/kmeans.hpp"
#include "math/least_squares.hpp"
#include "math/time_curve.hpp"
#include "splinevox/core/vec3.hpp"
#include "support/dual.hpp"

using namespace splinevox;
using test::Dual;

namespace {

const double kTimes[] = {0, 0.1, 0.25, 1 / 3.0, 0.5, 0.61, 0.75, 0.9, 1};

}  // namespace

TEST_SUITE("math/time_curve") {
  TEST_CASE(
      "nothing said is the identity; a curve is straight between its knots and jumps to the later value") {
    CHECK(TimeCurve{}(0.37) == 0.37);
    CHECK(TimeCurve{}.slope(0.37) == 1);
    CHECK(TimeCurve{}(-2) == 0);
    const TimeCurve c = simplified({{0, 0.5}, {0.25, 1}, {0.25, 0}, {1, 0.75}});
    CHECK(c(0) == 0.5);
    CHECK(c(0.125) == 0.75);
    CHECK(c(0.25) == 0);
    CHECK(c.before(0.25) == 1);
    CHECK(c(1) == 0.75);
    CHECK(c.slope(0.1) == 2);
    CHECK(c.slope(0.25) == 1);
    CHECK(c.slope(1) == 1);
  }
  TEST_CASE("reversed twice is the same curve, bit for bit, whatever its knots are") {
    CHECK(compose(compose({}, reversed_time()), reversed_time()).identity());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < 50; ++i) {
      std::vector<double> times{0, 1};
      for (int k = 0; k < 6; ++k) times.push_back(u(random));
      std::sort(times.begin(), times.end());
      std::vector<TimeCurve::Knot> knots;
      for (const double t : times) knots.push_back({t, u(random)});
      knots.insert(knots.begin() + 3, {knots[2].time, u(random)});  // a jump
      const TimeCurve c = simplified(knots), back = compose(c, reversed_time());
      CHECK(compose(back, reversed_time()) == c);
      for (const double t : {0.125, 0.3125, 0.77}) CHECK(back(1 - t) == doctest::Approx(c(t)).epsilon(1e-12));
    }
  }
  TEST_CASE("one change of time after the other is both at once") {
    const TimeCurve changes[] = {{},
                                 reversed_time(),
                                 speed_time(0.5),
                                 speed_time(3),
                                 loop_time(3, false),
                                 loop_time(2, true),
                                 frozen_time(0.3),
                                 simplified({{0, 0}, {0.5, 0.2}, {1, 1}}),
                                 simplified({{0, 0.9}, {0.4, 0.1}, {0.4, 0.6}, {1, 0}})};
    for (const TimeCurve& outer : changes)
      for (const TimeCurve& inner : changes) {
        const TimeCurve both = compose(outer, inner);
        for (double t = 0.0007; t < 1; t += 0.0131) CHECK(std::abs(both(t) - outer(inner(t))) <= 1e-9);
      }
  }
  TEST_CASE("a change that ends at a jump shows what is before the jump, also where its time is rounded") {
    const TimeCurve third = compose(loop_time(3, false), speed_time(1 / 3.0));
    CHECK(third(1) == 1);
    CHECK(third(0.999) == doctest::Approx(0.999).epsilon(1e-9));
    CHECK(compose(loop_time(3, false), frozen_time(1 / 3.0))(0.5) == 0);
  }
  TEST_CASE("a lap begins with its first moment, also where its time is no multiple of 2^-40") {
    for (const int count : {3, 5, 6, 7, 30})
      for (int i = 1; i < count; ++i) {
        const TimeCurve laps = loop_time(count, false);
        CHECK(laps(double(i) / count) < 1e-9);
        CHECK(laps(double(i) / count) >= 0);
        CHECK(laps.before(double(i) / count) == 1);
        CHECK(laps.slope(double(i) / count) == doctest::Approx(count));
      }
    const TimeCurve jump = simplified({{0, 0}, {0.3, 1}, {0.3, 0}, {1, 1}});
    CHECK(jump(0.3) == 0);
  }
  TEST_CASE("half speed shows at 2t what was at t; loops come round; frozen stands") {
    for (const double t : kTimes) {
      if (t <= 0.5) CHECK(speed_time(0.5)(2 * t) == t);
      CHECK(frozen_time(0.3)(t) == 0.3);
      CHECK(frozen_time(0.3).slope(t) == 0);
      CHECK(reversed_time()(t) == 1 - t);
    }
    CHECK(speed_time(2)(0.75) == 1);
    CHECK(speed_time(2).slope(0.75) == 0);
    CHECK(loop_time(1, false).identity());
    CHECK(loop_time(4, false)(0.375) == doctest::Approx(0.5));
    CHECK(loop_time(4, false)(1) == 1);
    CHECK(loop_time(2, true)(0.25) == doctest::Approx(1));
    CHECK(loop_time(2, true)(1) == 0);
  }
}

TEST_SUITE("math/basis_pieces") {
  TEST_CASE("derivatives equal the dual numbers' inside the pieces; places sum to 1") {
    for (const double t : {0.03, 0.2, 0.41, 0.77, 0.99})
      for (const int pieces : {1, 2, 5}) {
        const int p = 3 * pieces + 1, h = 2 * (pieces + 1);
        const auto poly = poly_bezier_weights(p, Dual{t, 1}), hermite = hermite_weights(h, Dual{t, 1});
        const auto d_poly = poly_bezier_weights_dt(p, t), d_hermite = hermite_weights_dt(h, t);
        double sum = 0, places = 0;
        for (int k = 0; k < p; ++k) {
          sum += poly[k].a;
          CHECK(d_poly[k] == doctest::Approx(poly[k].b).epsilon(1e-12));
        }
        for (int k = 0; k < h; ++k) CHECK(d_hermite[k] == doctest::Approx(hermite[k].b).epsilon(1e-12));
        for (int k = 0; k < h; k += 2) places += hermite[k].a;
        CHECK(sum == doctest::Approx(1));
        CHECK(places == doctest::Approx(1));
      }
  }
  TEST_CASE(
      "the ends are exactly the first and the last place; a Hermite node has the velocity it is given") {
    for (const double t : {0.0, 1.0}) {
      const auto poly = poly_bezier_weights(10, t), hermite = hermite_weights(8, t);
      for (int k = 0; k < 10; ++k) CHECK(poly[k] == (k == (t == 0 ? 0 : 9) ? 1.0 : 0.0));
      for (int k = 0; k < 8; ++k) CHECK(hermite[k] == (k == (t == 0 ? 0 : 6) ? 1.0 : 0.0));
    }
    for (int node = 0; node < 4; ++node) {
      const auto d = hermite_weights_dt(8, node / 3.0);
      for (int k = 0; k < 8; ++k)
        CHECK(d[k] == doctest::Approx(k == 2 * node + 1 ? 1.0 : 0.0).epsilon(1e-12));
    }
  }
  TEST_CASE("one poly-Bezier piece is a cubic Bezier curve") {
    for (const double t : kTimes)
      for (int k = 0; k < 4; ++k) CHECK(poly_bezier_weights(4, t)[k] == bernstein_weights(4, t)[k]);
  }
}

TEST_SUITE("math/least_squares") {
  TEST_CASE("an exact system is solved; the residual of another is orthogonal to what could be reached") {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    Matrix a(12, 5), b(12, 3);
    for (double& x : a.v) x = normal(random);
    for (double& x : b.v) x = normal(random);
    const Matrix x = least_squares(a, b), reached = product(a, x);
    for (int j = 0; j < 5; ++j)
      for (int c = 0; c < 3; ++c) {
        double dot = 0;
        for (int i = 0; i < 12; ++i) dot += a(i, j) * (reached(i, c) - b(i, c));
        CHECK(std::abs(dot) < 1e-12);
      }
    const Matrix again = least_squares(a, reached);
    for (std::size_t i = 0; i < x.v.size(); ++i) CHECK(again.v[i] == doctest::Approx(x.v[i]).epsilon(1e-12));
  }
}

TEST_SUITE("math/kmeans") {
  TEST_CASE(
      "the distance of trajectories has the unit of a place squared and does not grow with their moments") {
    const std::vector<float> a(12, 0.0f), b(12, 2.0f);
    CHECK(trajectory_distance(a.data(), b.data(), 4) == doctest::Approx(12));
    CHECK(trajectory_distance(a.data(), b.data(), 2) == doctest::Approx(12));
    CHECK(trajectory_distance(a.data(), a.data(), 4) == 0);
  }
  TEST_CASE("what stands still, what rises and what turns come apart; weightless trajectories have no say") {
    std::vector<float> all, weights;
    std::vector<int> truth;
    std::mt19937 random(2);
    std::normal_distribution<float> noise(0, 0.02f);
    for (int i = 0; i < 300; ++i) {
      const int kind = i % 3;
      for (int t = 0; t < 8; ++t) {
        const float s = float(t) / 7 - 0.5f;
        const Vec3 p = kind == 0   ? Vec3{}
                       : kind == 1 ? Vec3{0, 0, s}
                                   : Vec3{std::cos(6 * s), std::sin(6 * s), 0};
        for (int a = 0; a < 3; ++a) all.push_back(p[a] + noise(random));
      }
      truth.push_back(kind);
      weights.push_back(1);
    }
    for (int t = 0; t < 24; ++t) all.push_back(100);
    weights.push_back(0);
    const Clustering c = kmeans(all, weights, 8, 3);
    REQUIRE(c.centroid.size() == 3 * 24);
    for (int t = 0; t < 24; ++t) CHECK(c.centroid[t] == 0);
    for (int i = 0; i < 300; ++i) {
      CHECK((c.label[i] == 0) == (truth[i] == 0));
      CHECK(c.label[i] == c.label[i % 3]);
    }
    CHECK(c.silhouette > 0.8);
    CHECK(kmeans(all, weights, 8, 3).label == c.label);
    CHECK(kmeans(all, weights, 8, 5).silhouette < c.silhouette);
    CHECK(kmeans(std::vector<float>(48, 0.0f), {1, 1}, 8, 4).label == std::vector<int>{0, 0});
  }
}
