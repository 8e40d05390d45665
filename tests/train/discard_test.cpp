// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "core/atomic_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "support/state_parts.hpp"

using namespace splinevox;

namespace {

const Dataset& few_balls() {
  static const Dataset data = make_synth("ball", {.frames = 8, .size = 24, .seed = 3});
  return data;
}

Config tiny_run() {
  Config c = test::small_run(60);
  c.grid.radiance = {12};
  c.grid.radiance_start = {0};
  c.grid.motion = {4};
  c.grid.motion_start = {0};
  c.motion.elevate_points = {};
  c.motion.elevate_start = {};
  c.sampling.rays = 64;
  c.sampling.frames = 2;
  c.loss.tv_density = c.loss.tv_color = c.loss.tv_sh = 0;
  return c;
}

/// The radiance rows of a state, which come first in their section.
Channels radiance_of(const std::vector<char>& state) {
  const std::vector<char> section = test::part(state, "radiance");
  Channels raw;
  Archive in(section);
  in(raw);
  return raw;
}

/// Where one of their values stands in the bytes of the state.
std::size_t place_of(const std::vector<char>& state, std::size_t value) {
  Channels raw = radiance_of(state);
  Archive again;
  again(raw);
  const std::size_t end =
      test::parts_of(state).at("radiance").first + std::size_t(total_size(again.pieces()));
  return end - (raw.values.size() - value) * sizeof(float);
}

/// A trainer with one parameter that is no number.
struct Poisoned {
  Trainer trainer{tiny_run(), *few_balls().find("train"), few_balls().time_map};
  std::vector<char> state;
  explicit Poisoned(std::size_t value) {
    for (int i = 0; i < 10; ++i) trainer.step();
    state = trainer.save();
    const float bad = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(state.data() + place_of(state, value), &bad, sizeof bad);
    trainer.restore(state);
  }
};

}  // namespace

TEST_SUITE("train/discard") {
  TEST_CASE("a step that is not finite changes no parameter, names its rays, and training goes on") {
    bool mixed = false;
    const Channels shape = radiance_of([] {
      Trainer t(tiny_run(), *few_balls().find("train"), few_balls().time_map);
      t.step();
      return t.save();
    }());
    for (std::size_t row = kBrickRows; row < shape.topology->rows() && !mixed; row += 37) {
      Poisoned p(row * std::size_t(shape.width));
      int good = 0, bad = 0;
      try {
        while (!p.trainer.done() && !(good && bad)) {
          const std::vector<char> before = p.trainer.save();
          const StepReport r = p.trainer.step();
          (r.discarded ? bad : good) += 1;
          CHECK(r.discarded == !p.trainer.discarded().empty());
          if (!r.discarded) {
            CHECK(std::isfinite(r.loss));
            continue;
          }
          CHECK(r.bad_rays.size() > 0);
          for (const BadRay& ray : r.bad_rays) {
            CHECK(ray.frame < int(few_balls().find("train")->frames.size()));
            CHECK(ray.index < r.rays);
            CHECK(length(ray.direction) == doctest::Approx(1).epsilon(1e-5));
          }
          const auto same = [](const AlignedVector<float>& a, const AlignedVector<float>& b) {
            return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
          };
          CHECK(same(radiance_of(before).values, radiance_of(p.trainer.save()).values));
        }
      } catch (const Error& e) {
        CHECK(e.fault == Fault::numeric);
      }
      mixed = good > 0 && bad > 0;
    }
    CHECK(mixed);
  }

  TEST_CASE("after five in a row the step counter is back at the last good step and an error is thrown") {
    Config config = tiny_run();
    config.loss.tv_color = 1e30f;
    config.loss.tv_share = 1;
    Trainer trainer(config, *few_balls().find("train"), few_balls().time_map);
    int steps = 0;
    std::string message;
    try {
      for (; steps < 60; ++steps) trainer.step();
    } catch (const Error& e) {
      CHECK(e.fault == Fault::numeric);
      message = e.what();
    }
    CAPTURE(message);
    CHECK(message.find("5 steps in a row were not finite") != std::string::npos);
    CHECK(message.find("from no ray: from a regulariser") != std::string::npos);
    REQUIRE(trainer.discarded().size() == 5);
    CHECK(trainer.discarded().front().step == steps - 4 + 1);
    std::int64_t step;
    const std::vector<char> state = test::part(trainer.save(), "steps");
    std::memcpy(&step, state.data(), sizeof step);
    CHECK(step == steps - 4);
    // Who goes on all the same meets five others, and not a step before the first.
    for (int again = 0; again < 3; ++again) {
      for (int i = 0; i < 4; ++i) CHECK(trainer.step().discarded);
      CHECK_THROWS_AS(trainer.step(), Error);
      CHECK(trainer.discarded().size() == 5);
      CHECK(trainer.discarded().front().step == steps - 4 + 1);
    }
  }

  TEST_CASE("a ray that failed is named with the picture it goes through, of a rig too") {
    const Dataset rig = make_synth("ball", {.frames = 4, .size = 24, .seed = 3, .rig = {.cameras = 4}});
    const Split& train = *rig.find("train");
    Config config = tiny_run();
    config.sampling.carve = 0.5f;  // into pictures of other moments
    Trainer trainer(config, train, rig.time_map);
    trainer.set_loss([](const RayBatch&, std::span<Vec3> gradients) {
      for (Vec3& g : gradients) g.x = std::numeric_limits<float>::quiet_NaN();
      return 0.0;
    });
    const StepReport r = trainer.step();
    REQUIRE(r.discarded);
    REQUIRE(r.bad_rays.size() > 0);
    for (const BadRay& ray : r.bad_rays) {
      const Vec3d to = cast<double>(ray.origin) - train.frames[std::size_t(ray.frame)].camera.position;
      CHECK(length(cross(to, cast<double>(ray.direction))) < 1e-4);  // it begins at that camera
    }
  }

  TEST_CASE("a state whose numbers cannot be is refused before anything is allocated") {
    Trainer trainer(tiny_run(), *few_balls().find("train"), few_balls().time_map);
    trainer.step();
    const std::vector<char> state = trainer.save();
    int refused = 0;
    // Every word of the head becomes as large as it can be: sizes, counts, stages.
    for (std::size_t at = 8; at < 4096; at += 4) {
      std::vector<char> spoiled = state;
      std::memset(spoiled.data() + at, 0x7f, 4);
      try {
        trainer.restore(spoiled);
      } catch (const Error& e) {
        CHECK(e.fault == Fault::input);
        ++refused;
      }
    }
    CHECK(refused > 5);
  }
}
