// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "backend/step.hpp"
#include "math/camera.hpp"
#include "math/robust_line.hpp"
#include "render/field_view.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/learn_depth.hpp"

/// Depth maps of training pictures.
namespace {

using namespace splinevox;

/// A still scene, filmed along a short arc before a wall: pictures leave much of its depth open.
Dataset arc(std::optional<DepthKind> depth) {
  SynthOptions o{.frames = 16, .size = 40, .orbit = 0.1, .depth = depth};
  o.look.room = true;
  return make_synth("static", o);
}

Config arc_run(int steps) {
  Config c = test::small_run(steps);
  c.motion.enabled = false;
  c.motion.light = false;
  c.motion.presence = false;
  c.grid.radiance = {32, 48};
  c.grid.box = {-3, -3, -1, 3, 3, 3};
  return c;
}

/// Mean share by which rendered depth is off. @param truth  metric, of the same pictures
double depth_error_of(const VoxelModel& model, const Dataset& truth) {
  double sum = 0;
  int count = 0;
  for (const Frame& f : truth.find("train")->frames) {
    const Rendered shown = render_image(model, f.camera, f.time);
    for (int y = 0; y < f.camera.height; ++y)
      for (int x = 0; x < f.camera.width; ++x) {
        const float z = f.depth.at(x, y, f.camera.width, f.camera.height);
        if (z == 0) continue;
        sum += std::min(1.0f, std::abs(*shown.depth.pixel(x, y) - z) / z);
        ++count;
      }
  }
  return sum / count;
}

TEST_SUITE("train/depth") {
  TEST_CASE(
      "a robust line passes by a tenth of points that are wrong; there is none through points that fall") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<double> x, y;
    for (int i = 0; i < 300; ++i) {
      x.push_back(-1 + 4 * uniform(random));
      const double on = 0.7 * x.back() + 3;
      y.push_back(i % 10 == 0 ? on * (1 + uniform(random)) : on * (1 + 0.01 * (uniform(random) - 0.5)));
    }
    const std::optional<Line> line = robust_line(x, y, 0.05);
    REQUIRE(line);
    CHECK(line->slope == doctest::Approx(0.7).epsilon(0.1));
    CHECK(line->start == doctest::Approx(3).epsilon(0.03));
    std::vector<double> falling = x;
    std::sort(falling.begin(), falling.end(), std::greater());
    std::vector<double> rising = y;
    std::sort(rising.begin(), rising.end());
    CHECK_FALSE(robust_line(falling, rising, 0.05));
    CHECK_FALSE(robust_line(std::vector<double>(100, 2.0), std::vector<double>(100, 3.0), 0.05));
    CHECK_FALSE(robust_line(std::span(x).first(5), std::span(y).first(5), 0.05));
  }

  TEST_CASE("depth of any kind brings the scene nearer to where it is") {
    const Config config = arc_run(300);
    const Dataset truth = arc(DepthKind::metric);
    const double without = depth_error_of(test::trained(config, arc({})), truth);
    CAPTURE(without);
    for (const auto& [kind, share] :
         {std::pair{DepthKind::metric, 0.5}, {DepthKind::relative, 0.8}, {DepthKind::inverse, 0.8}}) {
      const double with = depth_error_of(test::trained(config, arc(kind)), truth);
      CAPTURE(int(kind));
      CAPTURE(with);
      CHECK(with < share * without);
    }
  }

  TEST_CASE("no weight and no depth are the same, to the last bit") {
    Config config = arc_run(30);
    const VoxelModel plain = test::trained(config, arc({}));
    const VoxelModel deep = test::trained(config, arc(DepthKind::metric));
    CHECK(deep.radiance.raw.values != plain.radiance.raw.values);
    config.loss.depth = 0;
    CHECK(test::trained(config, arc(DepthKind::metric)).radiance.raw.values == plain.radiance.raw.values);
  }

  TEST_CASE("a run with depth that stops and resumes ends in the same bits") {
    const Config config = arc_run(70);
    const Dataset data = arc(DepthKind::relative);
    Trainer whole(config, *data.find("train"), data.time_map);
    std::vector<char> at_60;
    while (!whole.done())
      if (whole.step().step == 60) at_60 = whole.save();  // maps were fitted before step 51
    REQUIRE_FALSE(at_60.empty());
    Trainer resumed(config, *data.find("train"), data.time_map);
    resumed.restore(at_60);
    while (!resumed.done()) resumed.step();
    CHECK(resumed.finish().radiance.raw.values == whole.finish().radiance.raw.values);
  }

  TEST_CASE("depth is along the axis of the camera, a target along the ray; what is unknown asks nothing") {
    Dataset data = arc(DepthKind::metric);
    const Frame& frame = data.find("train")->frames[0];
    const DepthFit metric{{}, 1};
    const float step = 0.01f;
    const Box box{{-4, -4, -4}, {4, 4, 4}};
    const SynthScene scene = SynthScene::open("static", {.room = true});
    for (const auto& [x, y] : {std::pair{1, 1}, {20, 20}, {38, 5}}) {
      const Ray ray = camera_ray(frame.camera, x + 0.5, y + 0.5);
      RayInput<float> clipped = clip_ray(ray, box, step, 0.5f, Vec3{});
      const DepthTarget<float> t = depth_target(frame, x, y, ray, metric, clipped, step);
      const auto hit = scene.at(0).trace(ray);
      REQUIRE(hit);
      CHECK(1 / t.scale == doctest::Approx(hit->along).epsilon(1e-3));
      const double start = dot(cast<double>(clipped.origin) - ray.origin, ray.direction);
      CHECK(t.distance == doctest::Approx(hit->along - start).epsilon(3e-3));
      CHECK(depth_target(frame, x, y, ray, {}, clipped, step).scale == 0);
      clipped.count = 10;  // beyond the box: nothing before its end
      CHECK(depth_target(frame, x, y, ray, metric, clipped, step).distance == doctest::Approx(10 * step));
    }
  }

  TEST_CASE("a device that does not learn depth says so before the first step") {
    const Dataset data = arc(DepthKind::metric);
    const auto begin = [&](const Config& config) {
      Trainer(config, *data.find("train"), data.time_map, 0, nullptr, make_host_step(true));
    };
    Config config = arc_run(10);
    CHECK_THROWS_WITH_AS(begin(config), doctest::Contains("--device cpu"), Error);
    config.loss.depth = 0;
    CHECK_NOTHROW(begin(config));
  }
}

}  // namespace
