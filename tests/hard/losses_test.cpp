// SPDX-License-Identifier: Apache-2.0
// Hard cases H17 to H21 of docs/numerics.md: losses, metrics, velocity.
#include <doctest/doctest.h>

#include <limits>
#include <random>

#include "backend/host/optimiser.hpp"
#include "hard/measured.hpp"
#include "math/activation.hpp"
#include "math/divergence.hpp"
#include "math/offset.hpp"
#include "math/tv.hpp"
#include "math/velocity.hpp"
#include "splinevox/math/metrics.hpp"
#include "support/dual.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {
using Long = long double;
const auto root = [](const auto& x) {
  using std::sqrt;
  using test::sqrt;
  return sqrt(x);
};

/// SSIM over whole pictures no larger than the window, in long double by the two-pass definition; one
/// channel.
Long exact_ssim(const Image& a, const Image& b) {
  const int n = a.width;
  Long w[11], total = 0;
  for (int i = 0; i < n; ++i) total += w[i] = std::exp(-Long(i - n / 2) * (i - n / 2) / (2 * 1.5L * 1.5L));
  const auto mean = [&](auto&& f) {
    Long sum = 0;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        sum += w[x] * w[y] / (total * total) * f(Long(*a.pixel(x, y)), Long(*b.pixel(x, y)));
    return sum;
  };
  const Long ma = mean([](Long p, Long) { return p; }), mb = mean([](Long, Long q) { return q; });
  const Long va = mean([&](Long p, Long) { return (p - ma) * (p - ma); }),
             vb = mean([&](Long, Long q) { return (q - mb) * (q - mb); });
  const Long c = mean([&](Long p, Long q) { return (p - ma) * (q - mb); });
  return (2 * ma * mb + 1e-4L) * (2 * c + 9e-4L) / ((ma * ma + mb * mb + 1e-4L) * (va + vb + 9e-4L));
}
}  // namespace

TEST_SUITE("hard/losses") {
  TEST_CASE(
      "H17: the offset loss is finite and has its own gradient from |d| = 1e-30 to 1e3 and for every "
      "rigidity") {
    Worst gradient, in_float, softened;
    for (const double e : {1e-9, 1e-4, 1e-2})
      for (double size = 1e-30; size < 2e3; size *= 10)
        for (const double r : {0.0, 1e-6, 0.3, 0.7, 1.0}) {
          const Vec3d d{0.6 * size, -0.64 * size, 0.48 * size};  // |d| = size
          const auto term = offset_term(d, r, 0.3, e);
          REQUIRE(std::isfinite(term.value));
          const auto f = offset_term(cast<float>(d), float(r), 0.3f, float(e));
          REQUIRE(std::isfinite(f.value));
          REQUIRE(std::isfinite(f.d_r));
          const double slope = length(term.d_delta);
          for (int a = 0; a < 3; ++a) {
            Vec3T<Dual> dual{d.x, d.y, d.z};
            dual[a].b = 1;
            gradient.see(std::abs(term.d_delta[a] - offset_term(dual, Dual(r), Dual(0.3), Dual(e)).value.b) /
                         std::max(slope, 1e-300));
            if (slope > 1e-30) in_float.see(std::abs(double(f.d_delta[a]) - term.d_delta[a]) / slope / kUnit);
          }
          const double d_r = offset_term(Vec3T<Dual>{d.x, d.y, d.z}, Dual(r, 1), Dual(0.3), Dual(e)).value.b;
          gradient.see(std::abs(term.d_r - d_r) / std::max(std::abs(d_r), 0.3));
          if (size > 100 * e) softened.see(std::abs(slope / ((2 - r) * std::pow(size, 1 - r)) - 1));
        }
    measured("H17 gradient against dual numbers", gradient.value, 1e-10, "");
    measured("H17 gradient in float", in_float.value, 60);
    measured("H17 gradient against the printed form from 100 e on", softened.value, 2e-4, "");
  }
  TEST_CASE("H18: total variation at a flat place is 0 and not NaN, and small steps keep their digits") {
    Worst value, gradient;
    for (double size = 1e-12; size < 10; size *= 3) {
      const float v = 0.5f, x = float(0.5 + size), y = float(0.5 - 0.3 * size), z = float(0.5 + 0.7 * size);
      const auto tv = tv_term(v, x, y, z, kTvSoftening, root);
      const Long dx = Long(v) - x, dy = Long(v) - y, dz = Long(v) - z, s = dx * dx + dy * dy + dz * dz;
      if (s == 0) {
        CHECK(tv.value == 0);
        CHECK(tv.d_self == 0);
        continue;
      }
      const Long eps = 1e-10f, norm = std::sqrt(s + eps);
      value.see(double(std::abs(tv.value / (s / (norm + std::sqrt(eps))) - 1)) / kUnit);
      gradient.see(double(std::abs(tv.d_x + dx / norm) / (std::sqrt(s) / norm)) / kUnit);
    }
    measured("H18 value of a step of 1e-12 to 10", value.value, 6);
    measured("H18 gradient, of its length", gradient.value, 6);

    // The share of the bricks that a step visits, drawn 300 times: a visited entry has four times its whole
    // gradient, a quarter of the times (z-test, alpha 0.01, Sidak over 64 entries).
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    const std::vector<float> zero(8, 0.0f);
    Channels values = make_channels(make_dense_topology(make_lattice(box, 31)), 8, zero.data());
    std::mt19937 random(18);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (std::size_t i = std::size_t(kBrickRows) * 8; i < values.values.size(); i += 8)
      values.values[i] = uniform(random);
    const auto gradient_of = [&](float share, std::uint64_t draw) {
      Gradient out(values);
      std::vector<float> tv(values.width, 0.0f);
      tv[0] = 1;
      add_total_variation(values, tv, 1, share, draw, {}, out);
      return out;
    };
    const Gradient whole = gradient_of(1, 0);
    constexpr int draws = 300;
    double visits[65] = {};
    for (int d = 0; d < draws; ++d) {
      const Gradient part = gradient_of(0.25f, 1000 + std::uint64_t(d));
      for (int b = 1; b <= 64; ++b) {
        const std::size_t row = std::size_t(b) * kBrickRows + 100;
        const float g = part.values.row(row)[0];
        REQUIRE((g == 0 || g == doctest::Approx(4 * whole.values.row(row)[0])));
        visits[b] += g != 0;
      }
    }
    Worst z;
    for (int b = 1; b <= 64; ++b) z.see(std::abs(visits[b] / draws - 0.25) / std::sqrt(0.25 * 0.75 / draws));
    measured("H18 largest of 64 z-scores of the stochastic estimate", z.value, 3.8, "");
  }
  TEST_CASE(
      "H19: metrics of black, constant, identical and nearly flat pictures, one pixel and smaller than a "
      "window") {
    const auto picture = [](int side, auto&& f) {
      Image image{side, side, 1};
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) *image.pixel(x, y) = float(f(x, y));
      return image;
    };
    CHECK(std::isinf(psnr(picture(3, [](int, int) { return 0; }), picture(3, [](int, int) { return 0; }))));
    CHECK(capped_psnr(psnr(picture(3, [](int, int) { return 1; }), picture(3, [](int, int) { return 1; }))) ==
          kPsnrCap);
    Worst error;
    std::mt19937 random(19);
    std::normal_distribution<double> normal;
    for (const int side : {1, 3, 7, 11})
      for (const double level : {0.0, 0.5, 1.0})
        for (const double noise : {0.0, 1e-7, 1e-4, 1 / 255.0}) {
          const Image a = picture(side, [&](int, int) { return level; });
          const Image b = picture(side, [&](int, int) { return level + noise * normal(random); });
          const Image c = picture(side, [&](int x, int y) { return level + noise * ((x + y) % 2 ? 1 : -1); });
          const Image d = picture(side, [&](int x, int y) { return level - noise * ((x + y) % 2 ? 1 : -1); });
          error.see(std::abs(double(ssim(a, b) - exact_ssim(a, b))));
          error.see(std::abs(double(ssim(c, d) - exact_ssim(c, d))));  // anticorrelated
          CHECK(std::isfinite(ms_ssim(c, d)));
        }
    measured("H19 SSIM against two passes in long double", error.value, 1e-12, "");
    // A black picture against noise: nothing but C2 / (s^2 + C2) is left. At 42 dB that still calls them
    // alike, so eval reports PSNR beside it.
    const Image black = picture(64, [](int, int) { return 0; });
    Worst closed;
    for (const double s : {1 / 255.0, 2 / 255.0, 5 / 255.0}) {
      std::normal_distribution<double> noise(0, s);
      closed.see(std::abs(ssim(black, picture(64, [&](int, int) { return noise(random); })) -
                          9e-4 / (s * s + 9e-4)));
    }
    measured("H19 SSIM of black and noise against its closed form", closed.value, 0.08, "");
  }
  TEST_CASE("H20: the analytic divergence has no noise; a probe's square is biased by exactly the shear") {
    std::mt19937 random(20);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Worst bias, mean;
    for (int trial = 0; trial < 200; ++trial) {
      MotionJet<double> m;
      m.delta = {uniform(random), uniform(random), uniform(random)};
      for (Vec3d& d : m.d_delta) d = {uniform(random), uniform(random), uniform(random)};
      m.d_rho = {uniform(random), uniform(random), uniform(random)};
      const auto s = sigmoid(uniform(random));
      m.r = s.value;
      m.r1 = s.slope;
      m.r2 = s.slope * (1 - 2 * s.value);
      MotionJetAdjoint<double> unused;
      const double exact = divergence(m, unused);
      double first = 0, second = 0, shear = 0;
      for (int signs = 0; signs < 8; ++signs) {
        const double q = divergence_probe(
            m, Vec3d{signs & 1 ? 1. : -1., signs & 2 ? 1. : -1., signs & 4 ? 1. : -1.}, unused);
        first += q / 8;
        second += q * q / 8;
      }
      // J = grad (r Delta_0), its symmetric part off the diagonal.
      double j[3][3];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) j[i][k] = m.r * m.d_delta[k][i] + m.r1 * m.d_rho[k] * m.delta[i];
      for (int i = 0; i < 3; ++i)
        for (int k = i + 1; k < 3; ++k) shear += std::pow(j[i][k] + j[k][i], 2);
      mean.see(std::abs(first - exact) / kUnitDouble / 8);
      bias.see(std::abs(second - (exact * exact + shear)) / kUnitDouble / 64);
    }
    measured("H20 mean of the probes against the divergence, of 8", mean.value, 4, "u of double");
    measured("H20 mean square against div^2 + shear, of 64", bias.value, 4, "u of double");
  }
  TEST_CASE(
      "H21: velocity is that of the material: exact when rigid, finite and flagged where the warp folds") {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Worst rigid, naive;
    for (int trial = 0; trial < 2000; ++trial) {
      const Vec3d axis = normalize(Vec3d{uniform(random), uniform(random), uniform(random) + 2}),
                  x{uniform(random), uniform(random), uniform(random)};
      const double angle = 3 * uniform(random), c = std::cos(angle), s = std::sin(angle);
      // x' = R(-angle) x, turning at rate 1: dDelta/dt = -w x (R x), v = w x x.
      const auto turn = [&](const Vec3d& p) {
        return c * p - s * cross(axis, p) + ((1 - c) * dot(axis, p)) * axis;
      };
      Vec3d gradient[3];
      for (int k = 0; k < 3; ++k) {
        Vec3d e{};
        e[k] = 1;
        const Vec3d column = turn(e) - e;
        for (int i = 0; i < 3; ++i) gradient[i][k] = column[i];
      }
      const Vec3d d_dt = -cross(axis, turn(x)), want = cross(axis, x);
      const auto got = material_velocity(gradient, d_dt);
      CHECK_FALSE(got.folded);
      rigid.see(length(got.velocity - want));
      naive.see(length(-d_dt - want));
    }
    CHECK(naive.value > 1);  // dDelta/dt alone
    Worst bound;
    for (const double squash : {0.0, 1e-300, 1e-12, 1e-5, 0.01, 0.049, -0.01, -1.0}) {
      const Vec3d gradient[3] = {{squash - 1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
      const auto v = material_velocity(gradient, Vec3d{1, 0.3, -0.2});
      CHECK(v.folded);
      bound.see(length(v.velocity) / length(Vec3d{1, 0.3, -0.2}));
    }
    measured("H21 velocity of a rotation", rigid.value, 1e-12, "");
    measured("H21 largest velocity at a fold, of dDelta/dt", bound.value, 25, "");
  }
}
