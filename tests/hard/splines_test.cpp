// SPDX-License-Identifier: Apache-2.0
// Hard cases H1 to H7 of docs/numerics.md: curves.
#include <doctest/doctest.h>

#include <limits>
#include <random>
#include <vector>

#include "data/times/time_map.hpp"
#include "field/lattice/slice.hpp"
#include "hard/measured.hpp"
#include "math/bernstein.hpp"
#include "math/bspline.hpp"
#include "support/dual.hpp"
#include "train/refine.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

using Long = long double;

/// A motion field of one brick: 512 rows of three curves each, as the renderer evaluates them.
struct Curves {
  MotionField motion;
  Curves(BasisKind basis, int points, unsigned seed, bool constant = false) {
    motion.basis = basis;
    motion.points = points;
    motion.first_point = FirstPoint::free;
    motion.rigidity = false;
    const std::vector<float> zero(motion.width(), 0.0f);
    motion.levels = {make_channels(make_dense_topology(make_lattice({{0, 0, 0}, {1, 1, 1}}, 4)),
                                   motion.width(), zero.data())};
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (int i = 0; i < kBrickRows; ++i)
      for (int a = 0; a < 3; ++a) {
        const float start = uniform(random);
        for (int k = 0; k < points; ++k) row(i)[3 * k + a] = constant ? start : uniform(random);
      }
  }
  float* row(int i) { return motion.levels[0].row(kBrickRows + i); }
  const float* row(int i) const { return motion.levels[0].row(kBrickRows + i); }
  float point(int i, int a, int k) const { return row(i)[3 * k + a]; }
  float largest(int i, int a) const {
    float most = 0;
    for (int k = 0; k < motion.points; ++k) most = std::max(most, std::abs(point(i, a, k)));
    return most;
  }
  /// visit(row, axis, value) for every curve at a time, by the shipped path.
  template <class Visit>
  void at(double t, Visit&& visit) const {
    with(stored_weights(motion, t), visit);
  }
  template <class Visit>
  void with(const BasisWeights<float>& weights, Visit&& visit) const {
    const MotionSlice slice = make_slice(motion, weights);
    for (int i = 0; i < kBrickRows; ++i)
      for (int a = 0; a < 3; ++a) visit(i, a, slice.values[std::size_t(kBrickRows + i) * kSliceWidth + a]);
  }
  Long exact(const BasisWeights<Long>& w, int i, int a) const {
    Long sum = 0;
    for (int k = 0; k < motion.points; ++k) sum += w[k] * Long(point(i, a, k));
    return sum;
  }
};

const std::vector<double> kTimes{0, 1e-9, 1e-8, 0.1, 0.25, 1.0 / 3, 0.5, 0.7, 0.9, 1 - 1e-8, 0.999999, 1};

BasisWeights<Long> exact_weights(BasisKind basis, int points, double t) {
  return basis == BasisKind::bezier ? bernstein_weights(points, Long(t)) : bspline_weights(points, Long(t));
}

using Vector = std::vector<Long>;
using Matrix = std::vector<Vector>;

/// Cholesky factor of a symmetric positive definite matrix, in the lower half.
Matrix factor(Matrix a) {
  const int n = int(a.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] = i == j ? std::sqrt(a[i][i]) : a[i][j] / a[j][j];
    }
  return a;
}

/// Solves for a right side by the factor.
Vector solve(const Matrix& a, Vector b) {
  const int n = int(b.size());
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return b;
}

/// Length after which a vector comes out of repeated use of a map: its largest eigenvalue.
template <class Map>
Long growth(int n, const Map& map) {
  Vector v(n);
  for (int i = 0; i < n; ++i) v[i] = i % 2 ? -1 : 1 + 0.1L * i;
  Long length = 1;
  for (int step = 0; step < 60; ++step) {
    for (Long& x : v) x /= length;
    v = map(v);
    length = 0;
    for (const Long x : v) length += x * x;
    length = std::sqrt(length);
  }
  return length;
}

/// Condition of the Gram matrix of a basis over [0, 1], to about a percent.
double gram_condition(BasisKind basis, int points) {
  const int samples = 40 * points;
  Matrix g(points, Vector(points));
  for (int s = 0; s < samples; ++s) {
    const auto w = exact_weights(basis, points, (s + 0.5) / samples);
    for (int i = 0; i < points; ++i)
      for (int k = 0; w[i] != 0 && k < points; ++k) g[i][k] += w[i] * w[k];
  }
  const auto times = [&](const Vector& v) {
    Vector out(points);
    for (int i = 0; i < points; ++i)
      for (int k = 0; k < points; ++k) out[i] += g[i][k] * v[k];
    return out;
  };
  const Matrix half = factor(g);
  return double(growth(points, times) * growth(points, [&](const Vector& v) { return solve(half, v); }));
}

}  // namespace

TEST_SUITE("hard/splines") {
  TEST_CASE(
      "H1: the shipped evaluation is within 6 units at any number of points, exact at the ends and on "
      "constants") {
    Worst bezier, spline, constant, hull, reversal, sum;
    for (const BasisKind basis : {BasisKind::bezier, BasisKind::bspline})
      for (const int points : basis == BasisKind::bezier ? std::vector<int>{2, 3, 4, 5, 8, 12, 16, 20}
                                                         : std::vector<int>{4, 5, 12, 33, 64, 256}) {
        CAPTURE(points);
        const Curves curves(basis, points, unsigned(points)), still(basis, points, 7, true);
        for (const double t : kTimes) {
          CAPTURE(t);
          const auto exact = exact_weights(basis, points, t);
          curves.at(t, [&](int i, int a, float y) {
            const double most = curves.largest(i, a);
            (basis == BasisKind::bezier ? bezier : spline)
                .see(std::abs(double(y - curves.exact(exact, i, a))) / (kUnit * most));
            hull.see((std::abs(y) - most) / (kUnit * most));
          });
          still.at(t, [&](int i, int a, float y) {
            constant.see(std::abs(double(y) - still.point(i, a, 0)) /
                         (kUnit * std::abs(still.point(i, a, 0))));
          });
          double total = 0;
          for (const float w : stored_weights(curves.motion, t)) {
            REQUIRE(w >= 0);
            total += w;
          }
          sum.see(std::abs(total - 1) / kUnit);
          if (basis == BasisKind::bspline) continue;
          const auto forth = stored_weights(curves.motion, t), back = stored_weights(curves.motion, 1 - t);
          for (int k = 0; k < points; ++k)
            reversal.see(std::abs(double(forth[k]) - back[points - 1 - k]) / kUnit);
        }
        if (basis == BasisKind::bspline) continue;
        curves.at(0, [&](int i, int a, float y) { REQUIRE(y == curves.point(i, a, 0)); });
        curves.at(1, [&](int i, int a, float y) { REQUIRE(y == curves.point(i, a, points - 1)); });
      }
    measured("H1 Bezier, 2 to 20 points, of max|p|", bezier.value, 6);
    measured("H1 B-spline, 4 to 256 points, of max|p|", spline.value, 6);
    measured("H1 beyond the hull", hull.value, 8);
    measured("H1 a constant curve", constant.value, 8);
    measured("H1 reversed, per weight", reversal.value, 2);
    measured("H1 sum of the rounded weights", sum.value, 8);
  }
  TEST_CASE("H2: the adjoint is the same weights; the time derivative has the factor points - 1") {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(-1, 1);
    Worst identity, slope;
    for (const int points : {2, 5, 12, 20}) {
      const Curves curves(BasisKind::bezier, points, 3);
      for (const double t : {0.0, 0.3, 0.77, 1.0}) {
        // <B p, y> = <p, transpose(B) y> through contract_brick and expand_brick.
        std::vector<float> y(std::size_t(kBrickRows) * kSliceWidth, 0.0f);
        Long left = 0, right = 0, size = 0;
        curves.at(t, [&](int i, int a, float v) {
          const float g = y[std::size_t(i) * kSliceWidth + a] = uniform(random);
          left += Long(v) * g;
          size += std::abs(Long(v) * g);
        });
        Channels gradient = curves.motion.levels[0];
        std::fill(gradient.values.begin(), gradient.values.end(), 0.0f);
        expand_brick(curves.motion, stored_weights(curves.motion, t), RowMask::all(), y.data(), 1, gradient);
        for (int i = 0; i < kBrickRows; ++i)
          for (int c = 0; c < 3 * points; ++c)
            right += Long(gradient.row(kBrickRows + i)[c]) * curves.row(i)[c];
        identity.see(double(std::abs(left - right) / size) / kUnit);
        const auto dual = bernstein_weights(points, Dual(t, 1));
        const auto d = bernstein_weights_dt(points, t);
        for (int k = 0; k < points; ++k) slope.see(std::abs(d[k] - dual[k].b) / (points - 1) / kUnitDouble);
      }
    }
    for (const int points : {4, 12, 64, 256})
      for (const double t : {0.01, 0.3, 0.77, 0.9}) {
        const auto dual = bspline_weights(points, Dual(t, 1));
        const auto d = bspline_weights_dt(points, t);
        for (int k = 0; k < points; ++k) slope.see(std::abs(d[k] - dual[k].b) / (points - 3) / kUnitDouble);
      }
    measured("H2 <Bp, y> against <p, B'y>, of sum|.|", identity.value, 1);
    measured("H2 dB/dt against dual numbers, of the degree", slope.value, 40, "u of double");
  }
  TEST_CASE("H3: degree elevation point by point, 4 to 20, stays within 6 units of the curve") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-1, 1);
    Worst worst;
    for (int trial = 0; trial < 200; ++trial) {
      float p[20], q[20];
      Long first[20];
      for (int k = 0; k < 4; ++k) first[k] = p[k] = uniform(random);
      for (int points = 4; points < 20; ++points) {
        elevate_bezier(points, p, q);
        std::copy_n(q, points + 1, p);
      }
      for (const double t : kTimes) {
        const auto before = exact_weights(BasisKind::bezier, 4, t),
                   after = exact_weights(BasisKind::bezier, 20, t);
        Long a = 0, b = 0;
        for (int k = 0; k < 4; ++k) a += before[k] * first[k];
        for (int k = 0; k < 20; ++k) b += after[k] * p[k];
        worst.see(std::abs(double(a - b)) / kUnit);
      }
    }
    measured("H3 elevated 4 to 20 points, of 1", worst.value, 6);
  }
  TEST_CASE("H4: no time is reached by stepping from another: frame 10000 is as good as frame 1") {
    constexpr int points = 6, frames = 10000;
    const Curves curves(BasisKind::bezier, points, 4);
    Worst shipped;
    for (const int frame : {1, 17, 4999, 9999}) {
      const auto exact = exact_weights(BasisKind::bezier, points, double(frame) / frames);
      curves.at(double(frame) / frames, [&](int i, int a, float y) {
        shipped.see(std::abs(double(y - curves.exact(exact, i, a))) / kUnit);
      });
    }
    // What a table of forward differences in float makes of one of these curves.
    float difference[points];
    for (int k = 0; k < points; ++k)
      difference[k] = float(curves.exact(exact_weights(BasisKind::bezier, points, double(k) / frames), 0, 0));
    for (int order = 1; order < points; ++order)
      for (int k = points - 1; k >= order; --k) difference[k] -= difference[k - 1];
    for (int frame = 0; frame < frames; ++frame)
      for (int k = 0; k + 1 < points; ++k) difference[k] += difference[k + 1];
    const double naive = std::abs(double(difference[0] - curves.point(0, 0, points - 1)));
    CHECK(naive > 0.01);
    measured("H4 any of 10000 frames of a curve of 6 points", shipped.value, 6);
  }
  TEST_CASE(
      "H5: the basis for many points is as well conditioned with 256 of them as with 8; Bernstein's is not") {
    CHECK(gram_condition(BasisKind::bezier, 8) > 1e3);
    CHECK(gram_condition(BasisKind::bezier, 16) > 1e8);
    Worst worst;
    for (const int points : {8, 12, 32, 64, 128, 256}) worst.see(gram_condition(BasisKind::bspline, points));
    measured("H5 condition of the B-spline's Gram matrix, 8 to 256 points", worst.value, 2000, "");

    // Least squares on 40 clustered times with noise 1e-3, no regularisation: between the times as good as at
    // them.
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    constexpr int frames = 40, points = 12;
    std::vector<double> times;
    for (int i = 0; i < frames; ++i) times.push_back(std::pow((i + 0.5) / frames, 1.3));
    const auto truth = [](double t) { return std::sin(3 * t) + 0.3 * t; };
    Matrix a(points, Vector(points));
    Vector b(points);
    for (const double t : times) {
      const auto w = exact_weights(BasisKind::bspline, points, t);
      const Long y = truth(t) + 1e-3 * normal(random);
      for (int i = 0; i < points; ++i) {
        b[i] += w[i] * y;
        for (int k = 0; k < points; ++k) a[i][k] += w[i] * w[k];
      }
    }
    const Vector p = solve(factor(a), b);
    double between = 0;
    for (int i = 0; i + 1 < frames; ++i) {
      const double t = 0.5 * (times[i] + times[i + 1]);
      const auto w = bspline_weights(points, t);
      double value = 0;
      for (int k = 0; k < points; ++k) value += w[k] * double(p[k]);
      between += std::pow(value - truth(t), 2) / (frames - 1);
    }
    measured("H5 error between 40 clustered times, 12 points, over the noise", std::sqrt(between) / 1e-3, 3,
             "");
  }
  TEST_CASE(
      "H6: one common time is 0, times beyond the ends are the ends, and no time reads past the weights") {
    for (const double t : {0.0, 0.3, -7.0, 1e6})
      CHECK(data::fit_time_map({t, t, t + 1e-10}) == TimeMap{t, 0});
    CHECK(data::fit_time_map({5}) == TimeMap{5, 0});
    const TimeMap mapped = data::fit_time_map({-3, 1e9, 4});
    CHECK(mapped(-3) == 0);
    CHECK(mapped(1e9) == 1);
    for (const BasisKind basis : {BasisKind::bezier, BasisKind::bspline})
      for (const int points : {4, 12, 20}) {
        const Curves curves(basis, points, 6);
        const auto first = stored_weights(curves.motion, 0), last = stored_weights(curves.motion, 1);
        for (const double t : {-1e-9, -0.0, -1e30, -std::numeric_limits<double>::infinity()})
          CHECK(stored_weights(curves.motion, t) == first);
        for (const double t : {1 + 1e-9, 1e30, std::numeric_limits<double>::infinity()})
          CHECK(stored_weights(curves.motion, t) == last);
        // The readers refuse NaN; here it must be no way out of the array, and seen.
        CHECK(std::isnan(stored_weights(curves.motion, std::nan(""))[points - 1]));
      }
  }
  TEST_CASE("H7: pieces of a spline of 256 points join in position and velocity, by construction") {
    constexpr int points = kMaxPoints, pieces = points - 3;
    const Curves curves(BasisKind::bspline, points, 7);
    Worst jump, kink;
    for (int joint = 1; joint < pieces; ++joint) {
      const double t = double(joint) / pieces;
      const auto after = stored_weights(curves.motion, t),
                 before = stored_weights(curves.motion, std::nextafter(t, 0.0));
      const auto d_after = stored_weights_dt(curves.motion, t),
                 d_before = stored_weights_dt(curves.motion, std::nextafter(t, 0.0));
      for (int i = 0; i < 8; ++i) {
        Long y = 0, d = 0, fastest = 0;
        for (int k = 0; k < points; ++k) {
          y += (Long(after[k]) - Long(before[k])) * curves.point(i, 0, k);
          d += (Long(d_after[k]) - Long(d_before[k])) * curves.point(i, 0, k);
          if (k > 0)
            fastest =
                std::max(fastest, std::abs(Long(curves.point(i, 0, k)) - curves.point(i, 0, k - 1)) * pieces);
        }
        jump.see(double(std::abs(y)) / kUnit);
        kink.see(double(std::abs(d) / fastest) / kUnit);
      }
    }
    measured("H7 jump of position at 252 joints, of 1", jump.value, 4);
    measured("H7 jump of velocity, of max|v|", kink.value, 8);
  }
}
