// SPDX-License-Identifier: Apache-2.0
#include "math/composite.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "math/light.hpp"
#include "math/warp.hpp"
#include "support/dual.hpp"

using namespace splinevox;
using test::Dual;

namespace {

constexpr int kRaw = 6;  ///< density, r, g, b, view, light of a sample
constexpr double kScale = 1.7, kShift = -0.4, kStep = 0.3;
constexpr Vec3d kBehind{0.2, 0.9, 0.4}, kGradient{0.7, -1.1, 0.4};  ///< colour behind, d loss / d pixel

/// What a sample gives off, by its raw values.
template <bool Viewed, class T>
Emission<T> emission(const T* raw) {
  const RawSample<T> sample{raw[0], {raw[1], raw[2], raw[3]}, raw[4]};
  Emission<T> e = emission_of<Viewed>(sample, T(kScale), T(kShift));
  const Activated<T> light = light_gain(raw[5]);
  e.light = light.value;
  e.light_slope = light.slope;
  return e;
}

/// One ray, front to back over its samples and the colour behind them; loss = colour . kGradient.
template <bool Viewed, class T>
T loss(const std::vector<T>& raw) {
  Vec3T<T> rgb{};
  T through = 1;
  for (std::size_t i = 0; i < raw.size(); i += kRaw) {
    const Emission<T> e = emission<Viewed>(&raw[i]);
    const Opacity<T> o = opacity_of(e.sigma, T(kStep));
    composite_sample(e, o.alpha, through, rgb);
    through *= o.passed;
  }
  T sum = 0;
  for (int c = 0; c < 3; ++c) sum += T(kGradient[c]) * (rgb[c] + through * T(kBehind[c]));
  return sum;
}

/// Its gradient by the adjoints, last sample first.
template <bool Viewed>
std::vector<double> gradient(const std::vector<double>& raw) {
  struct Sample {
    Emission<double> e;
    double w, next;
  };
  std::vector<Sample> samples;
  Vec3d rgb{};
  double through = 1;
  for (std::size_t i = 0; i < raw.size(); i += kRaw) {
    const Emission<double> e = emission<Viewed>(&raw[i]);
    const Opacity<double> o = opacity_of(e.sigma, kStep);
    const double w = composite_sample(e, o.alpha, through, rgb);
    through *= o.passed;
    samples.push_back({e, w, through});
  }
  std::vector<double> out(raw.size());
  double behind = through * dot(kBehind, kGradient);
  for (std::size_t s = samples.size(); s-- > 0;) {
    const auto& [e, w, next] = samples[s];
    const EmissionAdjoint<double> d = emission_vjp(e, composite_vjp(e, w, next, kStep, behind, kGradient));
    behind += composite_share(e, w, kGradient);
    const double all[kRaw] = {d.density, d.color.x, d.color.y, d.color.z, d.view, d.light};
    std::copy_n(all, kRaw, &out[s * kRaw]);
  }
  return out;
}

template <bool Viewed>
void check_gradient() {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-2, 2);
  std::vector<double> raw(7 * kRaw);
  for (double& x : raw) x = uniform(random);
  raw[3 * kRaw] = 60;  // a wall: what is behind it shows nothing
  const std::vector<double> found = gradient<Viewed>(raw);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    std::vector<Dual> moved(raw.begin(), raw.end());
    moved[i].b = 1;
    CAPTURE(i);
    CHECK(found[i] == doctest::Approx(loss<Viewed>(moved).b).epsilon(1e-12));
  }
}

}  // namespace

TEST_SUITE("math/composite") {
  TEST_CASE("the gradient of a ray by its raw values equals dual numbers, with view dependence and without") {
    check_gradient<true>();
    check_gradient<false>();
  }
  TEST_CASE("weights and what passes sum to one; a ray ends below its stop, not at it") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(0, 3);
    double sum = 0, through = 1;
    Vec3d rgb{};
    const Emission<double> white{.base = {1, 1, 1}};
    for (int i = 0; i < 40; ++i) {
      const Opacity<double> o = opacity_of(uniform(random), 0.1);
      sum += composite_sample(white, o.alpha, through, rgb);
      through *= o.passed;
    }
    CHECK(sum + through == doctest::Approx(1).epsilon(1e-14));
    CHECK(rgb.x == doctest::Approx(sum).epsilon(1e-14));
    CHECK(ray_ends(0.0009, 0.001));
    CHECK_FALSE(ray_ends(0.001, 0.001));
  }
  TEST_CASE("a factor that is off is one and has no gradient") {
    const Emission<double> e = emission_of<false>(RawSample<double>{0.3, {0, 0, 0}, 5}, 1.0, 0.0);
    CHECK(e.view == 1);
    CHECK(e.light == 1);
    const EmissionAdjoint<double> d = emission_vjp(e, {1, 1, 1, {1, 1, 1}});
    CHECK(d.view == 0);
    CHECK(d.light == 0);
    CHECK(d.color.x == 0.25);
  }
  TEST_CASE("the gradient of a displacement equals dual numbers") {
    const double motion[4] = {0.3, -0.2, 0.5, 0.7}, offset = 0.4;
    const Vec3d d_delta{0.9, -0.4, 0.2};
    const Activated<double> r = rigidity_of(motion[3], offset);
    double found[4];
    displacement_vjp(d_delta, motion, r.value, r.slope, found);
    for (int i = 0; i < 4; ++i) {
      Dual moved[4];
      for (int j = 0; j < 4; ++j) moved[j] = {motion[j], double(i == j)};
      const Vec3T<Dual> delta = displacement_of(moved, rigidity_of(moved[3], Dual(offset)).value);
      double expected = 0;
      for (int a = 0; a < 3; ++a) expected += d_delta[a] * delta[a].b;
      CHECK(found[i] == doctest::Approx(expected).epsilon(1e-13));
    }
  }
}
