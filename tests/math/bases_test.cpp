// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "splinevox/math/basis.hpp"

using namespace splinevox;

namespace {

const std::vector<double> kTimes{0, 0.1, 0.26, 1.0 / 3, 0.5, 0.7, 0.999999, 1};

std::vector<int> allowed(const PointRule& rule) {
  std::vector<int> all;
  for (int points = 0; points <= kMaxPoints + 2; ++points)
    if (rule.allows(points)) all.push_back(points);
  return all;
}

std::vector<double> random_points(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> p(count);
  for (double& x : p) x = uniform(random);
  return p;
}

double curve(const BasisWeights<double>& w, const std::vector<double>& p) {
  return std::inner_product(p.begin(), p.end(), w.begin(), 0.0);
}

/// The largest jump of a function of s where two of `pieces` equal parts meet.
template <class F>
double largest_jump(int pieces, F&& f) {
  constexpr double kBeside = 1e-9;
  double most = 0;
  for (int joint = 1; joint < pieces; ++joint) {
    const double s = double(joint) / pieces;
    most = std::max(most, std::abs(f(s + kBeside) - f(s - kBeside)));
  }
  return most;
}

}  // namespace

TEST_SUITE("math/bases") {
  TEST_CASE("every basis is found by its kind and by its name, which no other has") {
    std::set<std::string> names;
    for (const Basis& b : all_bases()) {
      CHECK(&basis_of(b.kind) == &b);
      CHECK(find_basis(b.name) == &b);
      CHECK(names.insert(b.name).second);
    }
    CHECK(find_basis("spline") == nullptr);
    CHECK(basis_names().size() == all_bases().size());
    CHECK(std::string(trained_basis_names()).find("bezier or bspline") == 0);
  }
  TEST_CASE("an allowed number of points gives weights for just as many, whose places sum to one") {
    for (const Basis& b : all_bases()) {
      CAPTURE(b.name);
      const std::vector<int> counts = allowed(b.points);
      REQUIRE(!counts.empty());
      CHECK(counts.front() == b.points.least);
      CHECK(counts.front() >= kMinPoints);
      CHECK(counts.back() <= kMaxPoints);
      CHECK(b.points.allows(b.full));
      for (const int points : counts)
        for (const double s : kTimes) {
          CAPTURE(points);
          CAPTURE(s);
          const BasisWeights<double> w = b.weights(points, s), d = b.weights_dt(points, s);
          double places = 0, rates = 0;
          int used = 0;
          for (int k = 0; k < kMaxPoints; ++k) {
            if (k >= points) CHECK(w[k] == 0);
            if (k >= points) CHECK(d[k] == 0);
            used += w[k] != 0;
            if (!b.is_place(k)) continue;
            places += w[k];
            rates += d[k];
          }
          CHECK(std::abs(places - 1) <= 1e-13);
          CHECK(std::abs(rates) <= 1e-10);
          if (b.local) CHECK(used <= 4);
        }
    }
  }
  TEST_CASE("the derivative of the weights is their slope") {
    for (const Basis& b : all_bases())
      for (const int points : allowed(b.points)) {
        if (points > 24) continue;
        CAPTURE(b.name);
        CAPTURE(points);
        for (const double s : {0.03, 0.21, 0.37, 0.61, 0.83, 0.97}) {
          constexpr double kStep = 1e-6;
          const auto d = b.weights_dt(points, s), lo = b.weights(points, s - kStep),
                     hi = b.weights(points, s + kStep);
          for (int k = 0; k < points; ++k)
            CHECK(std::abs((hi[k] - lo[k]) / (2 * kStep) - d[k]) <= 1e-5 * (1 + std::abs(d[k])));
        }
      }
  }
  TEST_CASE("a basis may be pinned if and only if its curves begin in their first point") {
    for (const Basis& b : all_bases())
      for (const int points : allowed(b.points)) {
        CAPTURE(b.name);
        const BasisWeights<double> w = b.weights(points, 0);
        bool begins = w[0] == 1;
        for (int k = 1; k < points; ++k) begins = begins && w[k] == 0;
        if (points >= b.full) CHECK(begins == b.pinnable);
      }
  }
  TEST_CASE("pieces meet as smoothly as the basis says, and no more so") {
    for (const Basis& b : all_bases()) {
      if (!b.local) continue;
      CAPTURE(b.name);
      const int pieces = 5, points = b.points_of(pieces);
      REQUIRE(b.points.allows(points));
      CHECK(b.pieces(points) == pieces);
      const std::vector<double> p = random_points(points, 3);
      const auto speed = [&](double s) { return curve(b.weights_dt(points, s), p); };
      const auto bend = [&](double s) {
        constexpr double kStep = 1e-10;
        return (speed(s + kStep) - speed(s - kStep)) / (2 * kStep);
      };
      CHECK(largest_jump(pieces, [&](double s) { return curve(b.weights(points, s), p); }) < 1e-6);
      CHECK((largest_jump(pieces, speed) < 1e-4) == (b.smooth >= 1));
      CHECK((largest_jump(pieces, bend) < 1) == (b.smooth >= 2));
    }
  }
  TEST_CASE("refining gives more points and leaves the curve where it is") {
    for (const Basis& b : all_bases()) {
      if (b.refinement.kind == Refinement::Kind::none) {
        CHECK(b.refinement.refined(7) == 7);
        continue;
      }
      CAPTURE(b.name);
      for (const int points : allowed(b.points)) {
        const int more = b.refinement.refined(points);
        if (points < b.full || !b.points.allows(more)) continue;
        CAPTURE(points);
        CHECK(more > points);
        const std::vector<double> p = random_points(points, 5);
        std::vector<double> q(more);
        b.refinement(points, p.data(), q.data());
        const std::vector<float> narrow(p.begin(), p.end());
        std::vector<float> also(more);
        b.refinement(points, narrow.data(), also.data());
        for (const double s : kTimes)
          CHECK(std::abs(curve(b.weights(points, s), p) - curve(b.weights(more, s), q)) <= 1e-13);
        for (int k = 0; k < more; ++k) CHECK(std::abs(also[k] - q[k]) <= 1e-6);
      }
    }
  }
  TEST_CASE("most points are those from which so many refinements end at what is allowed") {
    for (const Basis& b : all_bases())
      for (int n = 0; n < 12; ++n) {
        CAPTURE(b.name);
        CAPTURE(n);
        const auto ends = [&](int points) {
          for (int i = 0; i < n && points <= kMaxPoints; ++i) points = b.refinement.refined(points);
          return points;
        };
        const int most = b.most_points(n);
        if (most >= b.full) CHECK(ends(most) <= b.points.most);
        CHECK((most == b.points.most || ends(most + 1) > b.points.most));
      }
    CHECK(basis_of(BasisKind::bspline).most_points(2) == 66);
    CHECK(basis_of(BasisKind::bspline).most_points(9) < 4);
  }
  TEST_CASE("another basis gets as many points as hold the curves exactly, or about as many as there were") {
    struct Row {
      BasisKind from;
      int points;
      BasisKind to;
      int expected;
    };
    using enum BasisKind;
    for (const Row& r :
         {Row{bspline, 7, poly_bezier, 13}, Row{bspline, 7, hermite, 10}, Row{bspline, 21, bezier, 20},
          Row{bspline, 3, bspline, 4}, Row{bezier, 3, bspline, 4}, Row{bezier, 9, bspline, 9},
          Row{bezier, 4, poly_bezier, 4}, Row{bezier, 7, poly_bezier, 7}, Row{bezier, 8, poly_bezier, 10},
          Row{bezier, 7, hermite, 6}, Row{poly_bezier, 13, bspline, 7}, Row{poly_bezier, 13, hermite, 10},
          Row{hermite, 10, poly_bezier, 13}, Row{hermite, 10, bspline, 7}, Row{bezier, 12, bezier, 12}}) {
      CAPTURE(basis_of(r.from).name);
      CAPTURE(basis_of(r.to).name);
      CAPTURE(r.points);
      CHECK(points_to_hold(basis_of(r.from), r.points, basis_of(r.to)) == r.expected);
    }
  }
  TEST_CASE("a rule of points says what it allows") {
    CHECK(PointRule{}.text() == "2 to 256 points");
    CHECK(PointRule{4, 256, 3, "one more than a multiple of 3"}.text() ==
          "4, 7, 10, ... points: one more than a multiple of 3");
    CHECK(basis_of(BasisKind::bspline).trained_points().text() == "4 to 256 points");
  }
}
