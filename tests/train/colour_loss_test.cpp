// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/colour_loss.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "backend/step.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "support/state_parts.hpp"

using namespace splinevox;
using test::same_parameters;

namespace {

const Dataset& small_ball() {
  static const Dataset data = make_synth("ball", {.frames = 12, .size = 32, .seed = 3});
  return data;
}

Trainer trainer_of(int steps) {
  Config c = test::small_run(steps);
  c.grid.radiance = {12, 16};
  c.sampling.rays = 512;
  return {c, *small_ball().find("train"), small_ball().time_map};
}

std::vector<char> state_at_end(Trainer& trainer) {
  while (!trainer.done()) trainer.step();
  return trainer.save();
}

}  // namespace

TEST_SUITE("train/colour_loss") {
  TEST_CASE("the photometric loss by way of the caller gives the same bits, and its value") {
    Trainer plain = trainer_of(30), asked = trainer_of(30);
    double value = 0;
    asked.set_loss([&](const RayBatch& rays, std::span<Vec3> gradients) {
      value = 0;
      for (std::size_t r = 0; r < rays.colours.size(); ++r) {
        const Vec3 error = rays.colours[r] - rays.targets[r];
        value += dot(error, error);
      }
      std::copy(rays.photometric.begin(), rays.photometric.end(), gradients.begin());
      return value;
    });
    const StepReport report = asked.step();
    plain.step();
    CHECK(report.loss >= value / double(report.rays));
    CHECK(value > 0);
    CHECK(same_parameters(state_at_end(plain), state_at_end(asked)));
  }

  TEST_CASE("rays are those of their pixels") {
    Trainer trainer = trainer_of(2);
    const Split& train = *small_ball().find("train");
    std::size_t seen = 0;
    trainer.set_loss([&](const RayBatch& rays, std::span<Vec3>) {
      for (std::size_t r = 0; r < rays.pixels.size(); ++r) {
        const RayBatch::Pixel& p = rays.pixels[r];
        CHECK(std::abs(length(rays.directions[r]) - 1) < 1e-5f);
        if (p.frame < 0) continue;
        ++seen;
        const Frame& frame = train.frames[std::size_t(p.frame)];
        CHECK(rays.times[r] == frame.time);
        const Vec3 target = composite(frame.image, p.x, p.y, rays.backgrounds[r]);
        CHECK(length(rays.targets[r] - target) < 1e-5f);
      }
      return std::optional<double>();
    });
    trainer.step();
    CHECK(seen > 200);
  }

  TEST_CASE("what the caller's loss asks for is learned: here red and blue change places") {
    Trainer trainer = trainer_of(150);
    double first = 0, last = 0;
    trainer.set_loss([&](const RayBatch& rays, std::span<Vec3> gradients) {
      double sum = 0;
      for (std::size_t r = 0; r < rays.colours.size(); ++r) {
        const Vec3 t = rays.targets[r], error = rays.colours[r] - Vec3{t.z, t.y, t.x};
        for (int c = 0; c < 3; ++c) {
          sum += std::abs(error[c]);
          gradients[r][c] = error[c] > 0 ? 1.0f : -1.0f;
        }
      }
      last = sum / double(rays.colours.size());
      if (first == 0) first = last;
      return std::optional(sum);
    });
    state_at_end(trainer);
    CHECK(last < 0.8 * first);
  }

  TEST_CASE("a loss that throws leaves training as it was, and without it the old one is back") {
    Trainer plain = trainer_of(20), stopped = trainer_of(20);
    for (int i = 0; i < 7; ++i) stopped.step();
    stopped.set_loss(
        [](const RayBatch&, std::span<Vec3>) -> std::optional<double> { throw std::domain_error("mine"); });
    CHECK_THROWS_AS(stopped.step(), std::domain_error);
    stopped.set_loss({});
    CHECK(same_parameters(state_at_end(plain), state_at_end(stopped)));
  }

  TEST_CASE("the lane kernels take none, and say so") {
    const Dataset& data = small_ball();
    Config c = preset("draft");
    c.run.max_time = 0;
    c.run.max_steps = 1;
    Trainer trainer(c, *data.find("train"), data.time_map, 0, nullptr, make_host_step(true));
    CHECK_THROWS_WITH_AS(
        trainer.set_loss([](const RayBatch&, std::span<Vec3>) { return std::optional<double>(); }),
        doctest::Contains("on the CPU alone"), Error);
  }
}
