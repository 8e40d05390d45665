// SPDX-License-Identifier: Apache-2.0
#include "backend/pictures.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "backend/executors.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

/// A camera that sees the whole box from a little above.
Camera camera(int width, int height) {
  Camera c;
  c.width = width;
  c.height = height;
  c.fx = c.fy = 1.4 * width;
  c.cx = 0.5 * width;
  c.cy = 0.5 * height;
  c.position = {3.2, 0.5, 1.1};
  const Vec3d back = normalize(c.position), right = normalize(cross(Vec3d{0, 0, 1}, back));
  c.axes = {right, cross(back, right), back};
  return c;
}

double farthest(const Image& a, const Image& b) {
  REQUIRE(a.data.size() == b.data.size());
  double most = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    most = std::max(most, double(std::abs(a.data[i] - b.data[i])));
  return most;
}

}  // namespace

TEST_SUITE("backend/pictures") {
  TEST_CASE(
      "a device's pictures are those of the CPU to a few units of rounding, in every layer, for every "
      "kernel") {
    const Camera eye = camera(45, 38);  // no whole number of tiles
    for (const test::Runner& runner : test::runners()) {
      double worst = 0;
      for (int sh = -1; sh <= 3; ++sh)
        for (const int motion : {0, 1, 2}) {
          CAPTURE(runner.name);
          CAPTURE(sh);
          CAPTURE(motion);
          const test::BlobMotion moves{motion > 0, 4,           {-0.3f, 0.1f, 0.2f},
                                       0.15f,      motion == 2, motion == 2 ? 0.8f : 0.0f};
          VoxelModel model = test::blob_model(40, moves, sh);
          model.background.order = sh;
          for (int j = 0; j < model.background.count(); ++j)
            model.background.raw[j] = {0.3f * float(j), 0.5f, -0.2f * float(j)};
          Renderer cpu(model), device(model, runner.pictures(model));
          for (const double time : {0.0, 0.7}) {
            // To the end of the ray: where it may stop early, a transmittance beside the limit falls on
            // either side of it.
            const RenderOptions all{.stop = 0};
            const Rendered a = cpu.render(eye, time, all), b = device.render(eye, time, all);
            CHECK(*std::max_element(a.alpha.data.begin(), a.alpha.data.end()) > 0.9f);
            // 4 units of rounding for each of the up to 100 samples that a pixel is made of.
            constexpr double kTolerance = 100 * 4 * 6e-8;
            CHECK(farthest(a.rgb, b.rgb) < kTolerance);
            CHECK(farthest(a.alpha, b.alpha) < kTolerance);
            CHECK(farthest(a.rigidity, b.rigidity) < kTolerance);
            CHECK(farthest(a.flow, b.flow) < kTolerance);
            // A quotient of two sums that may both be small; the farthest corner is 4 units away.
            CHECK(farthest(a.depth, b.depth) < 1e-3);
            worst = std::max(worst, farthest(a.rgb, b.rgb));
            const RenderOptions early;
            CHECK(farthest(cpu.render(eye, time, early).rgb, device.render(eye, time, early).rgb) <=
                  early.stop);
          }
        }
      std::printf("%s: pictures differ from the CPU's by %.2e at most\n", runner.name.c_str(), worst);
    }
  }
  TEST_CASE("surroundings show on a device too, also before one colour that a user asked for") {
    VoxelModel model = test::blob_model(40, {}, 0);
    const std::vector<float> row{2, 1.5f, 0, -1, 0, 0, 0, 0};  // dense, and of no colour that is behind them
    model.surroundings.box = model.box;
    model.surroundings.raw = make_channels(outer_topology(16), int(row.size()), row.data());
    model.background = {.color = {1, 0, 1}};
    const Camera eye = camera(45, 38);
    Renderer cpu(model);
    const Image expected = cpu.render(eye, 0.5).rgb;
    for (const test::Runner& runner : test::runners()) {
      Renderer device(model, runner.pictures(model));
      CHECK(farthest(expected, device.render(eye, 0.5).rgb) < 1e-5);
    }
    model.surroundings = {};
    CHECK(farthest(expected, Renderer(model).render(eye, 0.5).rgb) > 0.1);  // they are there to be seen
  }
  TEST_CASE("several rays a pixel are the means of a finer picture's squares, of depth over what was hit") {
    const VoxelModel model = test::blob_model(40, {true, 4, {-0.3f, 0.1f, 0.2f}, 0.15f, true, 0.8f}, 1);
    const Camera eye = camera(45, 38);
    Camera fine = eye;
    fine.width *= 2;
    fine.height *= 2;
    for (double* of_picture : {&fine.fx, &fine.fy, &fine.cx, &fine.cy}) *of_picture *= 2;
    Renderer renderer(model);
    const Rendered all = renderer.render(fine, 0.7), mean = renderer.render(eye, 0.7, {.across = 2});
    const auto worst = [&](const Image& squares, const Image& found, const Image* weights) {
      double most = 0;
      for (int y = 0; y < found.height; ++y)
        for (int x = 0; x < found.width; ++x)
          for (int c = 0; c < found.channels; ++c) {
            double sum = 0, weight = 0;
            for (int k = 0; k < 4; ++k) {
              const int u = 2 * x + k % 2, v = 2 * y + k / 2;
              const double w = weights ? *weights->pixel(u, v) : 1;
              sum += w * squares.pixel(u, v)[c];
              weight += w;
            }
            most = std::max(most, std::abs((weight > 0 ? sum / weight : 0) - found.pixel(x, y)[c]));
          }
      return most;
    };
    constexpr double kTolerance = 1e-5;  // the same rays, by another camera's roundings
    CHECK(worst(all.rgb, mean.rgb, nullptr) < kTolerance);
    CHECK(worst(all.alpha, mean.alpha, nullptr) < kTolerance);
    CHECK(worst(all.flow, mean.flow, nullptr) < kTolerance);
    CHECK(worst(all.rigidity, mean.rigidity, nullptr) < kTolerance);
    CHECK(worst(all.depth, mean.depth, &all.alpha) < 1e-3);
    CHECK(farthest(mean.rgb, renderer.render(eye, 0.7).rgb) > 0.01);
    CHECK(farthest(renderer.render(eye, 0.7, {.across = 1}).rgb, renderer.render(eye, 0.7).rgb) == 0);
    REQUIRE(rays_across(model, eye) == 2);
    CHECK(farthest(renderer.render(eye, 0.7, {.across = 0}).rgb, mean.rgb) == 0);
  }
  TEST_CASE("a pixel wants several rays where it shows several voxels") {
    const VoxelModel model = test::blob_model(40, {}, 1);
    const double voxel = model.radiance.raw.topology->lattice.spacing;
    Camera eye = camera(100, 100);
    const double away = length(eye.position - cast<double>(model.box.center()));
    eye.fx = eye.fy = 2.3 * away / voxel;
    CHECK(rays_across(model, eye) == 2);
    eye.fx = eye.fy = 2.5 * away / voxel;
    CHECK(rays_across(model, eye) == 1);
    eye.position = cast<double>(model.box.center());  // from within
    CHECK(rays_across(model, eye) == 1);
  }
  TEST_CASE("a device's picture of noise in every number is the CPU's") {
    for (const test::Runner& runner : test::runners()) {
      const VoxelModel model = test::noisy_model(5, 6, FirstPoint::free, BasisKind::bspline, 2, true, true);
      Renderer cpu(model), device(model, runner.pictures(model));
      const RenderOptions all{.stop = 0};
      const Rendered a = cpu.render(camera(32, 32), 0.4, all), b = device.render(camera(32, 32), 0.4, all);
      CAPTURE(runner.name);
      CHECK(farthest(a.rgb, b.rgb) < 100 * 4 * 6e-8);
    }
  }
}
