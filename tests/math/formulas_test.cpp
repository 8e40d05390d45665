// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "math/aabb.hpp"
#include "math/activation.hpp"
#include "math/adam.hpp"
#include "math/bspline.hpp"
#include "math/curve_prior.hpp"
#include "math/divergence.hpp"
#include "math/offset.hpp"
#include "math/photometric.hpp"
#include "math/sh.hpp"
#include "math/tridiagonal.hpp"
#include "math/trilinear.hpp"
#include "math/tv.hpp"
#include "math/view_factor.hpp"
#include "support/dual.hpp"

using namespace splinevox;
using test::Dual;

namespace {
constexpr double kUnit = 5.9604644775390625e-08;  // float rounding, 2^-24
const auto root = [](const auto& x) {
  using std::sqrt;
  using test::sqrt;
  return sqrt(x);
};
}  // namespace

TEST_SUITE("math/activation") {
  TEST_CASE(
      "float exp, 1 - exp(-x), softplus and sigmoid keep their relative accuracy over their whole range") {
    double worst_exp = 0, worst_alpha = 0, worst_softplus = 0, worst_sigmoid = 0;
    for (double x = -80; x <= 80; x += 0.0137) {
      const float f = float(x);
      worst_exp = std::max(worst_exp, std::abs(exp_(f) / std::exp(double(f)) - 1));
      worst_softplus =
          std::max(worst_softplus, std::abs(softplus(f).value / (std::max(double(f), 0.0) +
                                                                 std::log1p(std::exp(-std::abs(double(f))))) -
                                            1));
      worst_sigmoid =
          std::max(worst_sigmoid,
                   std::abs(sigmoid(f).slope * std::pow(std::exp(f / 2.0) + std::exp(-f / 2.0), 2) - 1));
    }
    for (double e = -30; e <= 2; e += 0.01) {
      const float x = float(std::pow(10.0, e));
      worst_alpha = std::max(worst_alpha, std::abs(one_minus_exp_neg(x) / -std::expm1(-double(x)) - 1));
    }
    CHECK(worst_exp <= 4 * kUnit);
    CHECK(worst_alpha <= 4 * kUnit);
    CHECK(worst_softplus <= 6 * kUnit);
    CHECK(worst_sigmoid <= 8 * kUnit);
  }
  TEST_CASE("extreme arguments stay finite and a saturated sigmoid still has a slope") {
    for (const float x : {-1e30f, -110.0f, 110.0f, 1e30f}) {
      CHECK(std::isfinite(softplus(x).value));
      CHECK(std::isfinite(sigmoid(x).slope));
    }
    CHECK(sigmoid(20.0f).slope > 0);
    CHECK(one_minus_exp_neg(0.0f) == 0.0f);
    CHECK(one_minus_exp_neg(200.0f) == 1.0f);
  }
  TEST_CASE("raw density at another scale gives the same density, from nothing to opaque") {
    for (const double by : {0.5, 1.0, 1.3, 6.4}) {
      CAPTURE(by);
      double before = -1e9;
      for (double raw = -60; raw < 2000; raw += 0.37) {
        const double at = raw_at_scale(raw, -4.6, by);
        CHECK(softplus(at - 4.6).value * by == doctest::Approx(softplus(raw - 4.6).value).epsilon(1e-9));
        CHECK(at > before);
        before = at;
      }
      CHECK(raw_at_scale(1e30, 0, by) == doctest::Approx(1e30 / by));
    }
  }
  TEST_CASE("slopes equal dual-number derivatives") {
    for (const double x : {-30.0, -2.0, -0.1, 0.3, 5.0, 40.0}) {
      CHECK(sigmoid(x).slope == doctest::Approx(sigmoid(Dual{x, 1}).value.b).epsilon(1e-12));
      CHECK(softplus(x).slope == doctest::Approx(softplus(Dual{x, 1}).value.b).epsilon(1e-12));
      CHECK(view_factor(x).slope == doctest::Approx(view_factor(Dual{x, 1}).value.b).epsilon(1e-12));
    }
  }
  TEST_CASE("the view factor stays within [1/2, 1] for any coefficient") {
    for (const float q : {-1e30f, -3.0f, 0.0f, 3.0f, 1e30f}) {
      CHECK(view_factor(q).value >= 0.5f);
      CHECK(view_factor(q).value <= 1.0f);
    }
  }
}

TEST_SUITE("math/trilinear") {
  TEST_CASE("weights sum to one, reproduce a linear function, and have the stated derivatives") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int trial = 0; trial < 50; ++trial) {
      const Vec3d f{uniform(random), uniform(random), uniform(random)};
      double w[8], linear = 0, sum = 0, corner[8];
      double value = 0;
      Vec3d d[8], slope{};
      trilinear_weights(f, w);
      trilinear_weight_gradients(f, d);
      for (int c = 0; c < 8; ++c) {
        corner[c] = uniform(random);
        sum += w[c];
        linear += w[c] * (2 * (c >> 2) + 3 * (c >> 1 & 1) + 5 * (c & 1));
        value += corner[c] * w[c];
        slope += corner[c] * d[c];
      }
      CHECK(sum == doctest::Approx(1).epsilon(1e-14));
      CHECK(linear == doctest::Approx(2 * f.x + 3 * f.y + 5 * f.z).epsilon(1e-13));
      const auto v = trilinear_with_gradient(f, corner[0], corner[1], corner[2], corner[3], corner[4],
                                             corner[5], corner[6], corner[7]);
      CHECK(v.value == doctest::Approx(value).epsilon(1e-13));
      CHECK(v.dx == doctest::Approx(slope.x).epsilon(1e-12));
      CHECK(v.dy == doctest::Approx(slope.y).epsilon(1e-12));
      CHECK(v.dz == doctest::Approx(slope.z).epsilon(1e-12));
    }
  }
}

TEST_SUITE("math/sh") {
  TEST_CASE("harmonics are orthonormal over the sphere") {
    // Gauss-free quadrature: midpoint in z, which is exact enough with many bands of equal area, uniform in
    // angle.
    double gram[16][16] = {};
    const int bands = 2000, turns = 16;
    for (int i = 0; i < bands; ++i)
      for (int j = 0; j < turns; ++j) {
        const double z = -1 + (i + 0.5) * 2 / bands, r = std::sqrt(1 - z * z), a = 2 * M_PI * j / turns;
        double y[16];
        sh_basis(3, Vec3d{r * std::cos(a), r * std::sin(a), z}, y);
        for (int p = 0; p < 16; ++p)
          for (int q = 0; q < 16; ++q) gram[p][q] += y[p] * y[q] * 4 * M_PI / (bands * turns);
      }
    for (int p = 0; p < 16; ++p)
      for (int q = 0; q < 16; ++q) CHECK(std::abs(gram[p][q] - (p == q)) <= 1e-5);
  }
}

TEST_SUITE("math/losses") {
  TEST_CASE("total variation: derivatives equal dual numbers, flat is zero and not NaN") {
    struct Row {
      double v, x, y, z;
    };
    for (const Row& r : {Row{0.3, 0.1, 0.5, -0.2}, Row{1, 1, 1, 2}, Row{-2, 0, 3, 1}}) {
      const auto tv = tv_term(r.v, r.x, r.y, r.z, 1e-10, root);
      const auto with = [&](int i) {
        return tv_term(Dual{r.v, double(i == 0)}, Dual{r.x, double(i == 1)}, Dual{r.y, double(i == 2)},
                       Dual{r.z, double(i == 3)}, 1e-10, root)
            .value.b;
      };
      CHECK(tv.d_self == doctest::Approx(with(0)).epsilon(1e-12));
      CHECK(tv.d_x == doctest::Approx(with(1)).epsilon(1e-12));
      CHECK(tv.d_y == doctest::Approx(with(2)).epsilon(1e-12));
      CHECK(tv.d_z == doctest::Approx(with(3)).epsilon(1e-12));
    }
    const auto flat = tv_term(0.7, 0.7, 0.7, 0.7, 1e-10, root);
    CHECK(flat.value == 0);
    CHECK(flat.d_self == 0);
  }
  TEST_CASE(
      "priors on curves: derivatives equal dual numbers; a halved curve has no jump at its new knots, a "
      "resting one no NaN") {
    constexpr int kPoints = 13, kStride = 4, kSize = kPoints * kStride;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> p(kSize);
    for (double& x : p) x = uniform(random);
    const auto slopes_agree = [&](const auto& prior) {
      std::vector<double> gradient(kSize, 0.0);
      prior(p.data(), gradient.data());
      for (int i = 0; i < kSize; ++i) {
        std::vector<Dual> seeded(p.begin(), p.end()), unused(kSize);
        seeded[i].b = 1;
        CAPTURE(i);
        CHECK(gradient[i] == doctest::Approx(prior(seeded.data(), unused.data()).b).epsilon(1e-10));
      }
    };
    for (const bool pinned : {false, true})
      slopes_agree([&]<class T>(const T* row, T* gradient) {
        return curve_length_vjp<T>(row, kStride, kPoints, pinned, T(0.3), gradient);
      });
    for (const bool pinned : {false, true})
      slopes_agree([&]<class T>(const T* row, T* gradient) {
        return step_lengths_vjp<T, 1>(row + 3, kStride, pinned ? 0 : 1, kPoints, T(0.3), gradient + 3);
      });
    for (const bool pinned : {false, true})
      slopes_agree([&]<class T>(const T* row, T* gradient) {
        return static_curve_vjp<T>(row, kStride, kPoints, pinned, T(0.3), T(1e-2), gradient);
      });
    for (const int spacing : {2, 4})
      slopes_agree([&]<class T>(const T* row, T* gradient) {
        return knot_jumps_vjp<T>(row, kStride, kPoints, spacing, T(0.3), T(1e-2), gradient);
      });

    std::vector<double> x(8), halved(kPoints), rows(kSize, 0.0), gradient(kSize, 0.0);
    for (double& v : x) v = uniform(random);
    halve_bspline(8, x.data(), halved.data());
    for (int k = 0; k < kPoints; ++k) rows[kStride * k] = halved[k];
    CHECK(knot_jumps_vjp<double>(rows.data(), kStride, kPoints, 2, 1.0, 1e-20, gradient.data()) <= 1e-14);
    CHECK(knot_jumps_vjp<double>(rows.data(), kStride, kPoints, kPoints, 1.0, 1e-20, gradient.data()) > 1e-3);

    std::fill(gradient.begin(), gradient.end(), 0.0);
    const std::vector<double> still(kSize, 0.7);
    CHECK(knot_jumps_vjp<double>(still.data(), kStride, kPoints, 2, 1.0, 1e-5, gradient.data()) <= 1e-20);
    CHECK(static_curve_vjp<double>(still.data(), kStride, kPoints, false, 1.0, 1e-5, gradient.data()) == 0);
    for (const double g : gradient) CHECK(std::abs(g) <= 1e-9);

    // A curve that goes on as it went is not drawn back at its ends.
    std::vector<double> even(kSize, 0.0);
    for (int k = 0; k < kPoints; ++k) even[kStride * k] = 0.1 * (k + 1);
    for (const bool pinned : {false, true}) {
      std::fill(gradient.begin(), gradient.end(), 0.0);
      curve_length_vjp<double>(even.data(), kStride, kPoints, pinned, 1.0, gradient.data());
      CHECK(std::abs(gradient[kStride * (kPoints - 1)]) <= 1e-12);
      CHECK(std::abs(gradient[0]) <= 1e-12);
    }
    std::fill(gradient.begin(), gradient.end(), 0.0);
    curve_length_vjp<double>(even.data(), kStride, 3, false, 1.0, gradient.data());
    CHECK(gradient[kStride * 2] == doctest::Approx(0.2));  // three points have no inner step
  }
  TEST_CASE("a colour beyond what a picture can show is no error, one below it is") {
    const float bound = at_least(1.0f);
    CHECK(photometric_error(Vec3{1.5f, 0.75f, 0.5f}, Vec3{bound, bound, 0.25f}) == Vec3{0, -0.25f, 0.25f});
    CHECK(photometric_error(Vec3{1, 1.25f, 2}, Vec3{bound, 1, 0}) == Vec3{0, 0.25f, 2});
    CHECK(photometric_error(Vec3{1, 1.25f, 2}, Vec3{at_least(1.25f), at_least(0.5f), 1.5f}) ==
          Vec3{-0.25f, 0, 0.5f});
    CHECK(colour_of(Vec3{at_least(1.25f), 0, 1.5f}) == Vec3{1.25f, 0, 1.5f});
    CHECK(std::isnan(photometric_error(Vec3{std::nanf(""), 0, 0}, Vec3{bound, bound, bound})
                         .x));  // still found and discarded
  }
  TEST_CASE("offset loss: derivatives equal dual numbers, finite where the plain form is NaN") {
    for (const double size : {0.0, 1e-30, 1e-6, 0.1, 3.0})
      for (const double r : {0.0, 0.3, 1.0}) {
        CAPTURE(size);
        CAPTURE(r);
        const Vec3d d{size, -0.5 * size, 0.2 * size};
        const auto term = offset_term(d, r, 0.3, 1e-4);
        CHECK(std::isfinite(term.value));
        for (int a = 0; a < 3; ++a) {
          Vec3T<Dual> dd{d.x, d.y, d.z};
          dd[a].b = 1;
          CHECK(term.d_delta[a] ==
                doctest::Approx(offset_term(dd, Dual(r), Dual(0.3), Dual(1e-4)).value.b).epsilon(1e-10));
        }
        CHECK(term.d_r ==
              doctest::Approx(
                  offset_term(Vec3T<Dual>{d.x, d.y, d.z}, Dual(r, 1), Dual(0.3), Dual(1e-4)).value.b)
                  .epsilon(1e-10));
      }
  }
  TEST_CASE("divergence and probe: adjoints equal dual numbers; the probes average to the divergence") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1, 1);
    // Ingredients: delta 0..2, d_delta 3..11, d_rho 12..14, rho 15.
    double x[16];
    for (double& v : x) v = uniform(random);
    const auto jet = [&](auto tag, int seeded) {
      using T = decltype(tag);
      T v[16];
      for (int i = 0; i < 16; ++i) {
        v[i] = T(x[i]);
        if constexpr (std::is_same_v<T, Dual>) v[i].b = i == seeded;
      }
      MotionJet<T> m;
      m.delta = {v[0], v[1], v[2]};
      for (int j = 0; j < 3; ++j) m.d_delta[j] = {v[3 + 3 * j], v[4 + 3 * j], v[5 + 3 * j]};
      m.d_rho = {v[12], v[13], v[14]};
      const auto s = sigmoid(v[15]);
      m.r = s.value;
      m.r1 = s.slope;
      m.r2 = s.slope * (T(1) - T(2) * s.value);
      return m;
    };
    const auto entry = [](const MotionJetAdjoint<double>& d, int i) {
      return i < 3    ? d.delta[i]
             : i < 12 ? d.d_delta[(i - 3) / 3][(i - 3) % 3]
             : i < 15 ? d.d_rho[i - 12]
                      : d.rho;
    };
    MotionJetAdjoint<double> d;
    MotionJetAdjoint<Dual> unused;
    const double exact = divergence(jet(0.0, -1), d);
    for (int i = 0; i < 16; ++i)
      CHECK(entry(d, i) == doctest::Approx(divergence(jet(Dual(), i), unused).b).epsilon(1e-12));
    const Vec3d e{1, -1, 1};
    divergence_probe(jet(0.0, -1), e, d);
    for (int i = 0; i < 16; ++i)
      CHECK(
          entry(d, i) ==
          doctest::Approx(divergence_probe(jet(Dual(), i), Vec3T<Dual>{1, -1, 1}, unused).b).epsilon(1e-12));
    double mean = 0;
    for (int signs = 0; signs < 8; ++signs)
      mean +=
          divergence_probe(jet(0.0, -1),
                           Vec3d{signs & 1 ? 1.0 : -1.0, signs & 2 ? 1.0 : -1.0, signs & 4 ? 1.0 : -1.0}, d) /
          8;
    CHECK(mean == doctest::Approx(exact).epsilon(1e-12));
  }
}

TEST_SUITE("math/aabb and adam") {
  TEST_CASE("rays along axes, from inside, past a corner, and on a face") {
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    CHECK(intersect(box, {-3, 0, 0}, {1, 0, 0}).near == doctest::Approx(2));
    CHECK(intersect(box, {-3, 0, 0}, {1, 0, 0}).far == doctest::Approx(4));
    CHECK(intersect(box, {0, 0, 0}, {0, 0, 1}).near == 0);
    CHECK(intersect(box, {-3, 2, 0}, {1, 0, 0}).far < 0);
    CHECK(intersect(box, {3, 0, 0}, {1, 0, 0}).far < intersect(box, {3, 0, 0}, {1, 0, 0}).near);
    CHECK(intersect(box, {-3, 1, 0}, {1, 0, 0}).far == doctest::Approx(4));
  }
  TEST_CASE("bias corrections are exact in the limits") {
    const MomentFactors one = moment_factors(0.9, 0.999, 1e-8, 1),
                        many = moment_factors(0.9, 0.9999, 1e-8, 1e9);
    CHECK(one.correction1 == doctest::Approx(10));
    CHECK(one.correction2 == doctest::Approx(1000));
    CHECK(many.correction1 == 1);
    CHECK(many.correction2 == 1);
  }
}

TEST_SUITE("math/tridiagonal") {
  TEST_CASE("a tridiagonal system is solved, of one row as of many") {
    const std::vector<double> before{9, 1, 0.5, 2}, middle{4, 3, 2, 5}, after{1, 0.5, 1, 9}, x{1, -2, 3, 0.5};
    std::vector<double> right;
    for (std::size_t i = 0; i < 4; ++i)
      right.push_back((i > 0 ? before[i] * x[i - 1] : 0) + middle[i] * x[i] +
                      (i < 3 ? after[i] * x[i + 1] : 0));
    const std::vector<double> got = solve_tridiagonal(before, middle, after, right);
    for (std::size_t i = 0; i < 4; ++i) CHECK(got[i] == doctest::Approx(x[i]).epsilon(1e-12));
    const double two = 2, six = 6;
    CHECK(solve_tridiagonal({&two, 1}, {&two, 1}, {&two, 1}, {&six, 1}) == std::vector<double>{3});
  }
}
