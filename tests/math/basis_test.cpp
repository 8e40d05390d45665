// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <numeric>
#include <random>
#include <vector>

#include "math/bernstein.hpp"
#include "math/bspline.hpp"
#include "support/dual.hpp"

using namespace splinevox;
using test::Dual;

namespace {

const std::vector<double> kTimes{0, 1e-9, 0.1, 0.25, 1.0 / 3, 0.5, 0.7, 0.999999, 1};

/// Plain De Casteljau on one component: the paper's evaluator, here the oracle.
double de_casteljau(std::vector<double> p, double t) {
  for (std::size_t n = p.size(); n > 1; --n)
    for (std::size_t i = 0; i + 1 < n; ++i) p[i] = (1 - t) * p[i] + t * p[i + 1];
  return p[0];
}

template <class T>
T sum(const BasisWeights<T>& w) {
  return std::accumulate(w.begin(), w.end(), T(0));
}

}  // namespace

TEST_SUITE("math/basis") {
  TEST_CASE("Bernstein weights give the curve of De Casteljau for every number of points") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int points = kMinPoints; points <= kMaxBezierPoints; ++points)
      for (const double t : kTimes) {
        std::vector<double> p(points);
        for (double& x : p) x = uniform(random);
        const auto w = bernstein_weights(points, t);
        double y = 0;
        for (int k = 0; k < points; ++k) y += w[k] * p[k];
        CAPTURE(points);
        CAPTURE(t);
        CHECK(y == doctest::Approx(de_casteljau(p, t)).epsilon(1e-14));
      }
  }
  TEST_CASE("weights are non-negative, sum to one, and are what they should be at both ends") {
    for (int points = kMinPoints; points <= kMaxPoints; ++points) {
      CAPTURE(points);
      for (const double t : kTimes) {
        CAPTURE(t);
        for (const auto& w :
             {bernstein_weights(std::min(points, kMaxBezierPoints), t), bspline_weights(points, t)}) {
          CHECK(std::all_of(w.begin(), w.end(), [](double x) { return x >= 0; }));
          CHECK(std::abs(sum(w) - 1) <= 1e-14);
        }
      }
      if (points <= kMaxBezierPoints) {
        CHECK(bernstein_weights(points, 0.0)[0] == 1.0);
        CHECK(bernstein_weights(points, 1.0)[points - 1] == 1.0);
      }
      if (points < 4) continue;
      const auto first = bspline_weights(points, 0.0), last = bspline_weights(points, 1.0);
      for (int k = 0; k < 3; ++k) {
        CHECK(first[k] == doctest::Approx(k == 1 ? 4.0 / 6 : 1.0 / 6).epsilon(1e-14));
        CHECK(last[points - 1 - k] == doctest::Approx(k == 1 ? 4.0 / 6 : 1.0 / 6).epsilon(1e-12));
      }
    }
  }
  TEST_CASE("time derivatives equal dual-number derivatives and sum to zero") {
    for (int points = kMinPoints; points <= kMaxBezierPoints; ++points)
      for (const double t : {0.0, 0.1, 0.33, 0.5, 0.77, 0.9}) {
        CAPTURE(points);
        CAPTURE(t);
        const auto bezier = bernstein_weights(points, Dual{t, 1}),
                   spline = bspline_weights(points, Dual{t, 1});
        const auto d_bezier = bernstein_weights_dt(points, t), d_spline = bspline_weights_dt(points, t);
        for (int k = 0; k < points; ++k) {
          CHECK(std::abs(d_bezier[k] - bezier[k].b) <= 1e-12);
          CHECK(std::abs(d_spline[k] - spline[k].b) <= 1e-12);
        }
        CHECK(std::abs(sum(d_bezier)) <= 1e-12);
        CHECK(std::abs(sum(d_spline)) <= 1e-12);
      }
  }
  TEST_CASE("a B-spline is local, and of two points the same as a Bezier curve") {
    for (const double t : kTimes) {
      int used = 0;
      for (const double x : bspline_weights(12, t)) used += x != 0;
      CHECK(used <= 4);
      for (int k = 0; k < 2; ++k)
        CHECK(bspline_weights(2, t)[k] == doctest::Approx(bernstein_weights(2, t)[k]));
    }
  }
  TEST_CASE("pieces of a long B-spline join without a jump in position or velocity") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1, 1);
    constexpr int points = 203;  // 200 pieces
    std::vector<double> p(points);
    for (double& x : p) x = uniform(random);
    const auto curve = [&](const BasisWeights<double>& w) {
      return std::inner_product(p.begin(), p.end(), w.begin(), 0.0);
    };
    for (int joint = 1; joint < 200; ++joint) {
      const double t = joint / 200.0, before = std::nextafter(t, 0.0);
      CAPTURE(joint);
      CHECK(std::abs(curve(bspline_weights(points, t)) - curve(bspline_weights(points, before))) <= 1e-12);
      const double speed = curve(bspline_weights_dt(points, t));
      CHECK(std::abs(speed - curve(bspline_weights_dt(points, before))) <= 1e-10 * (1 + std::abs(speed)));
    }
  }
  TEST_CASE("halving the spans of a B-spline leaves the curve where it is") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int points = 4; 2 * points - 3 <= kMaxPoints; ++points) {
      std::vector<double> p(points), q(2 * points - 3);
      for (double& x : p) x = uniform(random);
      halve_bspline(points, p.data(), q.data());
      const auto curve = [](const std::vector<double>& at, double t) {
        return std::inner_product(at.begin(), at.end(), bspline_weights(int(at.size()), t).begin(), 0.0);
      };
      CAPTURE(points);
      for (const double t : kTimes) CHECK(std::abs(curve(p, t) - curve(q, t)) <= 1e-13);
    }
  }
  TEST_CASE("degree elevation leaves the curve where it is") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int points = kMinPoints; points < kMaxBezierPoints; ++points) {
      std::vector<double> p(points), q(points + 1);
      for (double& x : p) x = uniform(random);
      elevate_bezier(points, p.data(), q.data());
      for (const double t : kTimes) CHECK(std::abs(de_casteljau(p, t) - de_casteljau(q, t)) <= 1e-15 * 8);
    }
  }
}
