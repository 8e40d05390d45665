// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "backend/step.hpp"
#include "math/background_color.hpp"
#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/dual.hpp"
#include "support/small_run.hpp"

using namespace splinevox;
using splinevox::test::Dual;

namespace {

/// A sky that no single colour stands for: warm on one side, blue above.
Vec3 sky(const Ray& ray) {
  const Vec3d& d = ray.direction;
  return {float(0.55 + 0.25 * d.x), float(0.5 + 0.1 * d.y), float(0.45 + 0.3 * d.z)};
}

}  // namespace

TEST_SUITE("train/background") {
  TEST_CASE("the gradient of the harmonics is that of dual numbers") {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int order = 0; order <= kMaxShOrder; ++order) {
      const int count = (order + 1) * (order + 1);
      const Vec3d d = normalize(Vec3d{normal(random), normal(random), normal(random)}),
                  g{normal(random), normal(random), normal(random)};
      Vec3d raw[kMaxShCount], got[kMaxShCount] = {};
      for (Vec3d& r : raw) r = {normal(random), normal(random), normal(random)};
      background_color_vjp(order, d, background_color(order, raw, d).slope, g, got);
      for (int j = 0; j < count; ++j)
        for (int a = 0; a < 3; ++a) {
          Vec3T<Dual> dual[kMaxShCount];
          for (int k = 0; k < count; ++k) dual[k] = {raw[k].x, raw[k].y, raw[k].z};
          dual[j][a].b = 1;
          const Vec3T<Dual> c = background_color(order, dual, Vec3T<Dual>{d.x, d.y, d.z}).value;
          CHECK(got[j][a] == doctest::Approx(c.x.b * g.x + c.y.b * g.y + c.z.b * g.z).epsilon(1e-12));
        }
    }
  }
  TEST_CASE("a raw value far out stays finite and keeps a slope, and one colour is the same everywhere") {
    Background b{.color = {0.1f, 0.2f, 0.3f}};
    CHECK(b.towards({0, 0, 1}) == b.color);
    b.order = 0;
    for (const float raw : {-1e30f, -140.0f, 140.0f, 1e30f}) {
      b.raw[0] = {raw, raw, raw};
      const BackgroundColor<float> c = background_color(0, b.raw, Vec3{0, 1, 0});
      CHECK(c.value.x >= 0);
      CHECK(c.value.x <= 1);
      CHECK(std::isfinite(c.slope.x));
      if (std::abs(raw) < 1e3f)
        CHECK(c.slope.x > 0);  // where color (1 - color) is 0, and would never learn again
    }
  }
  TEST_CASE("behind opaque pictures the sky is learned, and the scene before it") {
    const Dataset data = test::ball_before(sky, 40, 40);
    Config config = test::small_run(400);
    const VoxelModel model = test::trained(config, data);
    config.run.background_order = -1;
    const VoxelModel fog = test::trained(config, data);
    REQUIRE(model.background.learned());
    CHECK_FALSE(fog.background.learned());
    const double with = test::test_psnr(model, data), without = test::test_psnr(fog, data);
    MESSAGE("test split: " << with << " dB with a learned background, " << without << " dB with one colour");
    CHECK(with > without + 3);
    const Frame& f = data.find("test")->frames.front();
    const Ray ray = camera_ray(f.camera, 0.5, 0.5);
    const Vec3 seen = model.background.towards(cast<float>(ray.direction)), truth = sky(ray);
    for (int c = 0; c < 3; ++c) CHECK(seen[c] == doctest::Approx(truth[c]).epsilon(0.05));
    // What is behind is behind: the corner of a picture is empty.
    CHECK(*render_image(model, f.camera, f.time).alpha.pixel(0, 0) < 0.25f);
  }
  TEST_CASE("pictures with alpha have nothing behind them") {
    const Dataset data = make_synth("ball", {.frames = 12, .size = 24});
    const VoxelModel model = test::trained(test::small_run(3), data);
    CHECK(model.background == Background{});
    CHECK(choose_effects(test::small_run(100), *data.find("train"), data.time_map)
              .chosen.order(Effect::background) == EffectSet::kOff);
  }
  TEST_CASE("whether a background is learned is tried like other effects") {
    Config config = preset("fast");
    config.run.max_time = 0;
    config.run.max_steps = 8000;
    config.run.surroundings = false;
    config.motion.presence = false;
    config.sampling.rays = 1024;
    const Dataset data = test::ball_before(sky, 40, 40);
    const EffectChoice choice = choose_effects(config, *data.find("train"), data.time_map);
    CHECK(choice.chosen.order(Effect::background) == 2);
    CHECK(choice.chosen.has(Effect::motion));
    REQUIRE_FALSE(choice.verdicts.empty());
    CHECK(choice.verdicts[0].effect == Effect::background);
    CHECK(choice.verdicts[0].decision == EffectDecision::on);
  }
  TEST_CASE("the same bits for any number of threads, and across a stop") {
    const Dataset data = test::ball_before(sky, 12, 24);
    const Config config = test::small_run(40);
    const VoxelModel one = test::trained(config, data, 1), three = test::trained(config, data, 3);
    CHECK(one.background == three.background);
    CHECK(one.radiance.raw.values == three.radiance.raw.values);

    Trainer first(config, *data.find("train"), data.time_map);
    for (int i = 0; i < 17; ++i) first.step();
    const std::vector<char> saved = first.save();
    Trainer second(config, *data.find("train"), data.time_map);
    second.restore(saved);
    while (!second.done()) second.step();
    CHECK(second.model().background == one.background);
    CHECK(second.model().radiance.raw.values == one.radiance.raw.values);
  }
  TEST_CASE("a device's steps learn the same background") {
    const Dataset data = test::ball_before(sky, 12, 24);
    const Config config = test::small_run(30);
    const VoxelModel cpu = test::trained(config, data);
    Trainer trainer(config, *data.find("train"), data.time_map, 0, nullptr, make_host_step(false));
    while (!trainer.done()) trainer.step();
    const VoxelModel device = trainer.model();
    CHECK_FALSE(cpu.background == Background{});
    for (int j = 0; j < cpu.background.count(); ++j)
      for (int a = 0; a < 3; ++a)
        CHECK(device.background.raw[j][a] ==
              doctest::Approx(cpu.background.raw[j][a]).epsilon(1e-2).scale(1));
  }
}
