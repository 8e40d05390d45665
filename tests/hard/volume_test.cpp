// SPDX-License-Identifier: Apache-2.0
// Hard cases H8 to H12 and H16 of docs/numerics.md: what a ray gathers.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "core/rng.hpp"
#include "hard/column.hpp"
#include "hard/measured.hpp"
#include "render/field_view.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/blob_model.hpp"
#include "train/batch.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

using Long = long double;
Long exact_softplus(Long x) { return std::max(x, Long(0)) + std::log1p(std::exp(-std::abs(x))); }
Long exact_sigmoid(Long x) { return x < 0 ? std::exp(x) / (1 + std::exp(x)) : 1 / (1 + std::exp(-x)); }

/// Raw density whose optical depth over a step of 1 is about `depth`.
float raw_of(double depth) { return float(depth > 30 ? depth : std::log(std::expm1(depth))); }

struct Composited {
  Long rgb[3] = {}, transmittance = 1;
  std::vector<Long> d_raw;  ///< derivative of G . rgb with respect to each raw density
};

/// Eq. 1 and its derivative in long double, with tau kept instead of the transmittance.
Composited exact(RayColumn<float>& column, int samples, const Vec3& g) {
  Composited out;
  std::vector<Long> depth(samples), along(samples), tau(samples + 1, 0);
  for (int i = 0; i < samples; ++i) {
    const float* row = column.row(i);
    depth[i] = exact_softplus(row[0]);
    for (int c = 0; c < 3; ++c) {
      const Long color = exact_sigmoid(row[1 + c]);
      out.rgb[c] += std::exp(-tau[i]) * -std::expm1(-depth[i]) * color;
      along[i] += color * g[c];
    }
    tau[i + 1] = tau[i] + depth[i];
  }
  out.transmittance = std::exp(-tau[samples]);
  Long behind = 0;
  for (int c = 0; c < 3; ++c) {
    out.rgb[c] += out.transmittance * column.ray.background[c];
    behind += out.transmittance * column.ray.background[c] * g[c];
  }
  out.d_raw.resize(samples);
  for (int i = samples - 1; i >= 0; --i) {
    out.d_raw[i] = (std::exp(-tau[i + 1]) * along[i] - behind) * exact_sigmoid(column.row(i)[0]);
    behind += std::exp(-tau[i]) * -std::expm1(-depth[i]) * along[i];
  }
  return out;
}

}  // namespace

TEST_SUITE("hard/volume") {
  TEST_CASE(
      "H8: alpha = 1 - exp(-x) keeps its digits from 1e-38 to 200, where the plain form has none below "
      "6e-8") {
    CHECK(1.0f - std::exp(-1e-8f) == 0.0f);
    Worst worst;
    const Rng rng(8, 0);
    for (int i = 0; i < 1000000; ++i) {
      const float x = float(std::pow(10.0, -38 + 40.3 * rng.uniform(i)));
      worst.see(std::abs(double(one_minus_exp_neg(x)) / -std::expm1(-double(x)) - 1) / kUnit);
    }
    measured("H8 1 - exp(-x)", worst.value, 6);
  }
  TEST_CASE(
      "H9: colour and gradient of a ray from fog to walls: no NaN, no wrong sign, no division by 1 - alpha") {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> uniform(-1, 1);
    Worst color, gradient, long_color;
    for (const int samples : {1, 16, 256, 4096})
      for (const double depth : {1e-9, 1e-6, 1e-3, 0.02, 1.0, 17.4, 1e3, 1e6})
        for (const bool wall : {false, true}) {
          CAPTURE(samples);
          CAPTURE(depth);
          RayColumn<float> column(samples);
          for (int i = 0; i < samples; ++i) {
            const double here = wall && i == samples / 2 ? 3000 : depth * (1 + 0.9 * uniform(random));
            column.set(i, raw_of(here), 3 * uniform(random), 3 * uniform(random), 3 * uniform(random));
          }
          const Vec3 g{0.3f, -0.7f, 1.1f};
          StillKernel<float, -1> kernel;
          const auto result = kernel.forward(column.ray, column.field, column.frame, 0);
          RayRecords<float, RayColumn<float>::kWidth, false> records;
          backward(kernel, column.ray, result, column.field, g, 0.0f, records);
          REQUIRE(records.radiance.size() == std::size_t(samples));
          const Composited truth = exact(column, samples, g);
          for (int c = 0; c < 3; ++c)
            (samples > 256 ? long_color : color).see(std::abs(double(result.rgb[c] - truth.rgb[c])) / kUnit);
          // Beside the sum of what is subtracted: T c and S may be as good as equal.
          Long tau = 0;
          for (int i = 0; i < samples; ++i) {
            const float got = records.radiance[std::size_t(samples - 1 - i)].g[0];
            const Long want = truth.d_raw[i], scale = std::exp(-tau) * exact_sigmoid(column.row(i)[0]);
            tau += exact_softplus(column.row(i)[0]);
            REQUIRE(std::isfinite(got));
            if (scale < 1e-30L) {
              // exp_ ends at exp(-87): behind more than that nothing is left.
              if (tau > 200) REQUIRE(std::abs(got) <= 1e-30f);
              continue;
            }
            gradient.see(double(std::abs(got - want) / scale) / kUnit / std::sqrt(samples));
            if (std::abs(want) > 1e-4L * scale) REQUIRE((got > 0) == (want > 0));
          }
        }
    measured("H9 colour, up to 256 samples, of 1", color.value, 10);
    measured("H9 colour, 4096 samples, of 1", long_color.value, 300);
    measured("H9 gradient, of T sigma' sqrt(samples)", gradient.value, 6);
  }
  TEST_CASE(
      "H10: a ray that stops early is off by less than what is left, and goes back from the sample it "
      "stopped at") {
    std::mt19937 random(10);
    std::uniform_real_distribution<float> uniform(-1, 1);
    Worst error;
    for (int trial = 0; trial < 20000; ++trial) {
      RayColumn<float> column(64);
      for (int i = 0; i < 64; ++i)
        column.set(i, raw_of(std::pow(10.0, -1 + uniform(random))), uniform(random), uniform(random),
                   uniform(random));
      const float stop = std::pow(10.0f, -3 + 2 * std::abs(uniform(random)));
      StillKernel<float, -1> kernel;
      const auto whole = kernel.forward(column.ray, column.field, column.frame, 0);
      const auto part = kernel.forward(column.ray, column.field, column.frame, stop);
      for (int c = 0; c < 3; ++c)
        error.see(std::abs(double(whole.rgb[c] - part.rgb[c])) / std::max(stop, 1e-30f));
      RayRecords<float, RayColumn<float>::kWidth, false> records;
      backward(kernel, column.ray, part, column.field, {1, 1, 1}, 0.0f, records);
      REQUIRE(records.radiance.size() == std::size_t(kernel.count));
      if (kernel.count < 64) REQUIRE(part.transmittance < stop);
      if (kernel.count > 1) REQUIRE(kernel.transmittance_next[kernel.count - 2] >= stop);
    }
    measured("H10 colour lost by stopping, of the threshold", error.value, 1, "");
  }
  TEST_CASE(
      "H11: softplus and the logistic slope keep their digits between -87 and 1e6 and never become 0 or "
      "infinite") {
    CHECK(std::log(1.0f + std::exp(-20.0f)) == 0.0f);  // the plain forms
    CHECK(std::isinf(std::log(1.0f + std::exp(89.0f))));
    Worst value, slope, rigid;
    for (double at = -86.9; at <= 110; at += 0.00037) {
      const float x = float(at);
      value.see(std::abs(double(softplus(x).value / exact_softplus(x)) - 1) / kUnit);
      slope.see(std::abs(double(softplus(x).slope / exact_sigmoid(x)) - 1) / kUnit);
      if (std::abs(x) < 86.9f)
        rigid.see(std::abs(double(sigmoid(x).slope / (exact_sigmoid(x) * exact_sigmoid(-Long(x)))) - 1) /
                  kUnit);
    }
    for (const float x : {-1e30f, -110.0f, -88.0f, 88.0f, 1e6f, 1e30f}) {
      CHECK(std::isfinite(softplus(x).value));
      CHECK(softplus(x).value > 0);
      CHECK(sigmoid(x).slope > 0);
    }
    measured("H11 softplus", value.value, 5);
    measured("H11 its slope", slope.value, 5);
    measured("H11 slope of the rigidity", rigid.value, 7);
  }
  TEST_CASE(
      "H12: a ray ends at the box: nothing there is the background bit for bit, and colour under alpha 0 "
      "does not "
      "count") {
    VoxelModel model = blob_model(16, {.moves = false});
    model.background.color = {0.123f, 0.456f, 0.789f};
    model.radiance.raw =
        make_channels(make_topology(model.radiance.raw.topology->lattice, {}), model.radiance.raw.width,
                      std::vector<float>(model.radiance.raw.width, 0.0f).data());
    Camera camera{8, 8, 10, 10, 4, 4, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 3}};
    const Rendered empty = render_image(model, camera, 0);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        for (int c = 0; c < 3; ++c) CHECK(empty.rgb.pixel(x, y)[c] == model.background.color[c]);
        CHECK(*empty.alpha.pixel(x, y) == 0);
      }
    // A thin fog up to the box's far side stays thin: no last sample of infinite length.
    RayColumn<float> fog(256);
    for (int i = 0; i < 256; ++i) fog.set(i, raw_of(1e-4), 0, 0, 0);
    StillKernel<float, -1> kernel;
    const auto result = kernel.forward(fog.ray, fog.field, fog.frame, 0);
    CHECK(result.transmittance == doctest::Approx(std::exp(-256e-4)).epsilon(1e-5));

    // D-NeRF's pictures carry garbage where alpha is 0; targets are composited from straight alpha.
    Image16 picture{8, 8, {}};
    std::mt19937 random(12);
    for (int i = 0; i < 64; ++i)
      for (int c = 0; c < 4; ++c)
        picture.rgba.push_back(c < 3 ? std::uint16_t(random()) : i % 3 == 0 ? 0 : i % 3 == 1 ? 65535 : 32768);
    const Split split{"train", {Frame{"a", camera, 0, picture, -1}}};
    SamplingConfig sampling;
    sampling.frames = 1;
    sampling.rays = 256;
    sampling.growth = 1;
    sampling.carve = 0;
    const BatchSampler sampler(split, model.box, sampling, 3);
    Batch batch;
    sampler.draw(0, 1, 0.05f, {}, {}, batch);
    int at_background = 0, inside = 0;
    for (std::size_t r = 0; r < batch.rays.size(); ++r) {
      at_background += batch.targets[r] == batch.rays[r].background;
      for (int c = 0; c < 3; ++c) inside += batch.targets[r][c] >= 0 && batch.targets[r][c] <= 1;
    }
    CHECK(at_background > 256 / 5);
    CHECK(inside == 3 * 256);
  }
  TEST_CASE(
      "H16: the march converges with the square of its step to the exact optical depth of two Gauss points a "
      "cell") {
    // Raw densities far above 0, where softplus is the identity: along a straight line a cubic per cell.
    const auto raw = [](int x, int y, int z) { return 40 + 8 * std::sin(1.3 * x + 2.1 * y - 0.7 * z * z); };
    const TopologyPtr t = make_dense_topology({{0, 0, 0}, 1, {9, 9, 9}});
    constexpr int kWidth = RayKernel<double, -1>::kWidth;
    std::vector<double> rows(t->rows() * kWidth);
    for (int b = 1; b <= t->brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i) {
        const Int3 v = t->vertex(b, i);
        rows[(std::size_t(b) * kBrickRows + i) * kWidth] = raw(v.x, v.y, v.z);
      }
    FieldView<double> field;
    field.radiance = BrickView<double>(*t);
    field.radiance_rows = rows.data();
    field.density_scale = 1e-3;
    const Box box{{0, 0, 0}, {8, 8, 8}};
    const auto exact_depth = [&](const Ray& ray, const Interval& inside) {
      std::vector<double> cuts{inside.near, inside.far};
      for (int a = 0; a < 3; ++a)
        for (int k = 1; k < 8; ++k)
          if (const double s = (k - ray.origin[a]) / ray.direction[a]; s > inside.near && s < inside.far)
            cuts.push_back(s);
      std::sort(cuts.begin(), cuts.end());
      double depth = 0;
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
        for (const double side : {-1.0, 1.0}) {
          const double half = 0.5 * (cuts[i + 1] - cuts[i]);
          const Vec3d x = ray.origin + (cuts[i] + half * (1 + side / std::sqrt(3.0))) * ray.direction;
          double w[8], value = 0;
          const int base[3] = {int(x.x), int(x.y), int(x.z)};
          trilinear_weights(Vec3d{x.x - base[0], x.y - base[1], x.z - base[2]}, w);
          for (int c = 0; c < 8; ++c)
            value += w[c] * raw(base[0] + (c >> 2), base[1] + (c >> 1 & 1), base[2] + (c & 1));
          depth += 1e-3 * half * value;
        }
      return depth;
    };
    const std::vector<int> steps{40, 80, 160, 320, 640};
    std::vector<double> squares(steps.size(), 0.0);
    constexpr int kRays = 40;
    for (int r = 0; r < kRays; ++r) {
      const Ray ray{{-1, 0.7 + 0.05 * r, 0.4 + 0.03 * r},
                    normalize(Vec3d{1, 0.61 - 0.02 * r, 0.43 - 0.01 * r})};
      const Interval inside = intersect(box, ray.origin, ray.direction);
      const double depth = exact_depth(ray, inside);
      for (std::size_t k = 0; k < steps.size(); ++k) {
        field.step = (inside.far - inside.near) / steps[k];
        RayInput<double> in = clip_ray(ray, box, field.step, 0.5, {});
        in.count = steps[k];
        StillKernel<double, -1> kernel;
        const auto result = kernel.forward(in, field, FrameView<double>{}, 0);
        squares[k] += std::pow(-std::log(result.transmittance) / depth - 1, 2) / kRays;
      }
    }
    const double order = 0.5 * std::log2(squares.front() / squares.back()) / 4;
    measured("H16 error of 640 steps through 8 cells, of the depth", std::sqrt(squares.back()), 1e-5, "");
    measured("H16 order of the march, minus 2", std::abs(order - 2), 0.3, "");
  }
}
