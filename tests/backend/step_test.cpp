// SPDX-License-Identifier: Apache-2.0
#include "backend/step.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

#include "backend/executors.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "support/state_parts.hpp"

using namespace splinevox;

namespace {

const Dataset& moving_ball() {
  static const Dataset data = make_synth("ball", {.frames = 24, .size = 48, .seed = 3});
  return data;
}

/// Every kernel of a step in miniature: several levels, light, rigidity, every loss, a curve that is elevated
/// on the way.
Config tiny_config(int steps, int sh_order, bool losses) {
  Config c = test::small_run(steps);
  c.run.seed = 7;
  c.radiance.sh_order = sh_order;
  c.grid.radiance_start = {0, 0.4f};
  c.grid.motion = {4, 8, 16};
  c.grid.motion_start = {0, 0.2f, 0.5f};
  c.motion.basis = BasisKind::bezier;
  c.motion.points = 3;
  c.motion.first_point = FirstPoint::zero;
  c.motion.elevate_points = {5};
  c.motion.elevate_start = {0.6f};
  if (losses) {
    c.loss.offset = 1e-3f;
    c.loss.divergence = 1e-3f;
    c.loss.divergence_kind = DivergenceKind::hutchinson;
    c.loss.curve_length = c.loss.curve_rest = 1e-4f;
  }
  c.loss.tv_density = 1e-4f;
  c.loss.tv_color = 1e-4f;
  c.loss.tv_sh = 1e-4f;
  c.loss.tv_control = 1e-3f;
  c.loss.tv_rigidity = 1e-4f;
  c.sampling.frames = 4;
  c.sampling.occupancy_every = 7;
  return c;
}

std::vector<StepReport> reports(const Config& config, std::unique_ptr<StepBackend> device, int steps) {
  Trainer trainer(config, *moving_ball().find("train"), moving_ball().time_map, 0, nullptr,
                  std::move(device));
  std::vector<StepReport> out;
  for (int i = 0; i < steps; ++i) out.push_back(trainer.step());
  return out;
}

/// Parameters and moments after some steps, on a number of threads.
std::string state(const Config& config, const std::function<std::unique_ptr<StepBackend>()>& device,
                  int steps, int threads) {
  return test::on_threads(threads, [&] {
    Trainer trainer(config, *moving_ball().find("train"), moving_ball().time_map, 0, nullptr, device());
    for (int i = 0; i < steps; ++i) trainer.step();
    return test::without(trainer.save(), {"clock"});
  });
}

}  // namespace

TEST_SUITE("backend/step") {
  TEST_CASE("a run on a device follows the CPU's: the same rays and samples, losses that part slowly") {
    for (const test::Runner& runner : test::runners())
      for (const bool deterministic : {false, true})
        for (const int sh : {1, 2}) {
          CAPTURE(runner.name);
          CAPTURE(deterministic);
          CAPTURE(sh);
          const Config config = tiny_config(30, sh, sh != 1);
          const auto cpu = reports(config, make_step(Device::cpu), 30),
                     device = reports(config, runner.step(deterministic), 30);
          double first = 0, last = 0;
          for (int i = 0; i < 30; ++i) {
            CHECK(device[i].step == cpu[i].step);
            CHECK(device[i].stage_changed == cpu[i].stage_changed);
            CHECK_FALSE(device[i].discarded);
            CHECK(std::abs(double(device[i].rays - cpu[i].rays)) == 0);
            const double apart = std::abs(device[i].loss / cpu[i].loss - 1);
            (i < 3 ? first : last) = std::max(i < 3 ? first : last, apart);
          }
          // Adam divides by the root of the second moment: a parameter with next to no gradient moves by a
          // whole rate this way or that.
          CHECK(first < 1e-5);
          CHECK(last < 1e-2);
          if (sh == 1)
            std::printf("%s%s: losses differ by %.1e in 3 steps, %.1e in 30\n", runner.name.c_str(),
                        deterministic ? ", deterministic" : "", first, last);
        }
  }
  TEST_CASE("what is behind the box is learned alike from a device's gradient and from the CPU's") {
    const Dataset data = test::ball_before(
        [](const Ray& ray) {
          return Vec3{0.5f + 0.3f * float(std::sin(4 * ray.direction.x)), 0.4f, 0.6f};
        },
        12, 24);
    Config config = test::small_run(12);
    config.grid.surroundings = {16};
    config.grid.surroundings_start = {0};
    for (const bool around : {false, true}) {
      CAPTURE(around);
      config.run.surroundings = around;
      const auto trained = [&](std::unique_ptr<StepBackend> device) {
        Trainer trainer(config, *data.find("train"), data.time_map, 0, nullptr, std::move(device));
        while (!trainer.done()) trainer.step();
        return trainer.model();
      };
      const VoxelModel cpu = trained(make_step(Device::cpu));
      REQUIRE(cpu.background.learned());
      REQUIRE(cpu.surroundings.any() == around);
      for (const test::Runner& runner : test::runners()) {
        CAPTURE(runner.name);
        const VoxelModel device = trained(runner.step(true));
        for (int j = 0; j < cpu.background.count(); ++j)
          for (int c = 0; c < 3; ++c)
            CHECK(device.background.raw[j][c] == doctest::Approx(cpu.background.raw[j][c]).epsilon(1e-2));
        const auto &a = device.surroundings.raw.values, &b = cpu.surroundings.raw.values;
        REQUIRE(a.size() == b.size());
        double apart = 0, moved = 0;
        for (std::size_t i = 4 * kBrickRows; i < a.size(); ++i) {
          apart += std::abs(a[i] - b[i]);
          moved += std::abs(b[i] - (i % 4 == 0 ? 0 : b[i % 4]));  // colours begin as that of row 0
        }
        CHECK(apart <= 1e-2 * moved);
        CHECK((moved > 0) == around);
      }
    }
  }
  TEST_CASE("deterministic: the same bits for any number of threads and again") {
    const Config config = tiny_config(24, 1, true);
    for (const test::Runner& runner : test::runners()) {
      CAPTURE(runner.name);
      const auto device = [&] { return runner.step(true); };
      const auto one = state(config, device, 24, 1);
      for (const int threads : {1, 3}) CHECK(one == state(config, device, 24, threads));
    }
  }
  TEST_CASE("a run on a device that is saved and restored goes on as it was, there or on the CPU") {
    const Config config = tiny_config(24, 1, false);
    const Split& train = *moving_ball().find("train");
    for (const test::Runner& runner : test::runners()) {
      CAPTURE(runner.name);
      const auto whole = state(
          config, [&] { return runner.step(true); }, 24, 2);
      Trainer first(config, train, moving_ball().time_map, 0, nullptr, runner.step(true));
      for (int i = 0; i < 11; ++i) first.step();
      const std::vector<char> saved = first.save();
      Trainer second(config, train, moving_ball().time_map, 0, nullptr, runner.step(true)),
          cpu(config, train, moving_ball().time_map);
      second.restore(saved);
      cpu.restore(saved);
      for (int i = 11; i < 24; ++i) {
        const StepReport a = second.step(), b = cpu.step();
        CHECK(a.loss == doctest::Approx(b.loss).epsilon(1e-2));
      }
      CHECK(test::without(second.save(), {"clock"}) == whole);
    }
  }
  TEST_CASE("what cannot be used changes no parameter, and the rays are named") {
    Config config = tiny_config(24, 1, false);
    const Split& train = *moving_ball().find("train");
    for (const test::Runner& runner : test::runners()) {
      CAPTURE(runner.name);
      Trainer trainer(config, train, moving_ball().time_map, 0, nullptr, runner.step(true));
      for (int i = 0; i < 8; ++i) trainer.step();  // the next step refreshes no occupancy
      std::vector<char> saved = trainer.save();
      // A colour that training has changed becomes NaN: every ray through it spoils its step.
      const VoxelModel model = trainer.model();
      const Channels& raw = model.radiance.raw;
      std::size_t row = kBrickRows, most = 0;
      for (std::size_t r = kBrickRows; r < raw.topology->rows(); ++r)
        if (std::abs(raw.row(r)[1] - raw.row(0)[1]) > std::abs(raw.row(most)[1] - raw.row(0)[1]))
          row = most = r;
      const char* needle = reinterpret_cast<const char*>(raw.row(row) + 1);
      const auto at = std::search(saved.begin(), saved.end(), needle, needle + 3 * sizeof(float));
      REQUIRE(at != saved.end());
      const float nan = std::nanf("");
      std::memcpy(&*at, &nan, sizeof nan);
      Trainer spoilt(config, train, moving_ball().time_map, 0, nullptr, runner.step(true));
      spoilt.restore(saved);
      const StepReport report = spoilt.step();
      CHECK(report.discarded);
      CHECK_FALSE(report.bad_rays.empty());
      CHECK(test::without(spoilt.save(), {"clock", "steps"}) == test::without(saved, {"clock", "steps"}));
    }
  }
}
