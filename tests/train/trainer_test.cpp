// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/trainer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "render/occupancy.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/small_run.hpp"
#include "support/state_parts.hpp"
#include "train/refine.hpp"

using namespace splinevox;
using test::same_parameters;

namespace {

const Dataset& moving_ball() {
  static const Dataset data = make_synth("ball", {.frames = 24, .size = 48, .seed = 3});
  return data;
}

/// A whole run in miniature: two lattices, two motion levels, every loss term, a Bezier curve that is
/// elevated on the way.
Config tiny_config(int steps) {
  Config c = test::small_run(steps);
  c.run.seed = 7;
  c.grid.radiance_start = {0, 0.4f};
  c.grid.motion_start = {0.1f, 0.5f};
  c.motion.basis = BasisKind::bezier;
  c.motion.points = 3;
  c.motion.first_point = FirstPoint::zero;
  c.motion.elevate_points = {5};
  c.motion.elevate_start = {0.6f};
  c.loss.offset = 1e-3f;
  c.loss.divergence = 1e-3f;
  c.loss.divergence_kind = DivergenceKind::hutchinson;
  c.loss.tv_density = 1e-4f;
  c.loss.tv_color = 1e-4f;
  c.loss.tv_sh = 1e-4f;
  c.loss.tv_control = 1e-3f;
  c.loss.tv_rigidity = 1e-4f;
  c.loss.curve_length = c.loss.curve_rest = 1e-4f;
  c.sampling.frames = 4;
  c.sampling.occupancy_every = 7;
  return c;
}

/// The same with a B-spline whose spans are halved on the way.
Config tiny_spline(int steps) {
  Config c = tiny_config(steps);
  c.motion.basis = BasisKind::bspline;
  c.motion.points = 6;
  c.motion.first_point = MotionConfig{}.first_point;
  c.motion.elevate_points.clear();
  c.motion.elevate_start.clear();
  c.motion.halve_start = {0.6f};
  c.loss.curve_knots = 1e-4f;
  return c;
}

std::vector<char> run(const Config& config, int threads, int from = 0, const std::vector<char>& state = {},
                      int to = 1 << 30) {
  return test::on_threads(threads, [&] {
    const Dataset& data = moving_ball();
    Trainer trainer(config, *data.find("train"), data.time_map);
    if (from > 0) trainer.restore(state);
    while (!trainer.done()) {
      const StepReport report = trainer.step();
      REQUIRE(std::isfinite(report.loss));
      if (report.step == to) break;
    }
    return trainer.save();
  });
}

}  // namespace

TEST_SUITE("train/trainer") {
  TEST_CASE(
      "the same seed gives the same bits with 1, 2, 3, 4 and 7 threads and again, another seed does not") {
    const Config config = tiny_config(40);
    const auto one = run(config, 1);
    for (const int threads : {1, 2, 3, 4, 7}) {
      CAPTURE(threads);
      CHECK(same_parameters(one, run(config, threads)));
    }
    Config other = config;
    other.run.seed = 8;
    CHECK_FALSE(same_parameters(one, run(other, 2)));
  }
  TEST_CASE("a run that stops and resumes ends in the same bits, wherever it stops") {
    const auto stop_and_resume = [](const Config& config, const std::vector<int>& stops) {
      const auto whole = run(config, 2);
      // A run that is stopped and resumed at each of them in turn; and from each of them straight to the end.
      std::vector<char> state;
      int from = 0;
      for (const int at : stops) {
        CAPTURE(at);
        if (at == from) continue;
        state = run(config, 1 + at % 3, from, state, at);
        from = at;
        CHECK(same_parameters(whole, run(config, 1 + (at + 1) % 3, at, state)));
      }
    };
    std::vector<int> stops{1,  4,  5,  15, 16, 17,
                           20, 21, 24, 25, 39};  // either side of refinements at 4, 16, 20 and 24
    std::mt19937 random(17);
    for (int i = 0; i < 5; ++i) stops.push_back(1 + int(random() % 39));
    std::sort(stops.begin(), stops.end());
    stop_and_resume(tiny_config(40), stops);
    stop_and_resume(tiny_spline(40), {16, 23, 24, 25, 39});
  }
  TEST_CASE("a state that is cut short is refused") {
    const Config config = tiny_config(6);
    auto state = run(config, 2);
    state.resize(state.size() / 2);
    Trainer trainer(config, *moving_ball().find("train"), moving_ball().time_map);
    CHECK_THROWS_AS(trainer.restore(state), Error);
  }
  TEST_CASE("the model at the end is the model") {
    const Dataset& data = moving_ball();
    Trainer trainer(tiny_spline(20), *data.find("train"), data.time_map);
    while (!trainer.done()) trainer.step();
    const VoxelModel before = trainer.model(), at_end = trainer.finish();
    CHECK(at_end.radiance.raw.values == before.radiance.raw.values);
    REQUIRE(at_end.motion.levels.size() == 1);
    CHECK(at_end.motion.levels[0].values == before.motion.levels[0].values);
    CHECK(at_end.motion.points == before.motion.points);
    CHECK(trainer.phases().rays > 0);
  }
  TEST_CASE("without rigidity a step of control points is a share of a cell of the finest motion level") {
    Config config = tiny_spline(40);
    config.grid.motion_start = {0, 0.5f};
    const Dataset& data = moving_ball();
    // Where the scene is still the same everywhere, as it is at first, nothing moves. Then Adam, whose steps
    // know no size of gradients, moves what has one by a share of the rate.
    const auto moved = [&](bool rigidity) {
      config.motion.rigidity = rigidity;
      Trainer trainer(config, *data.find("train"), data.time_map);
      trainer.step();
      trainer.step();
      const VoxelModel model = trainer.model();
      const Channels& level = model.motion.levels[0];
      float most = 0;
      for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r)
        for (int c = 0; c < model.motion.rigidity_column(); ++c)
          if (c % model.motion.stride() < 3) most = std::max(most, std::abs(level.row(r)[c]));
      return most;
    };
    const float with = moved(true);
    CHECK(with > 0);
    CHECK(moved(false) == doctest::Approx(with * 2 / 4).epsilon(0.01));
  }
  TEST_CASE("a moving ball is learned, and motion is what it takes") {
    Config config = preset("draft");
    config.run.max_time = 0;
    config.run.max_steps = 250;
    config.sampling.rays = 1024;
    config.grid.radiance = {24, 40};
    config.sampling.occupancy_cells = 32;
    config.grid.radiance_start = {0, 0.3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0.1f, 0.4f};
    const Dataset& data = moving_ball();
    const auto quality = [&](const Config& c) { return test::test_psnr(test::trained(c, data), data); };
    const double moving = quality(config);
    config.motion.enabled = false;
    const double still = quality(config);
    CAPTURE(moving);
    CAPTURE(still);
    CHECK(moving > 24);
    CHECK(moving > still + 3);
  }
  TEST_CASE("harmonics that join leave every picture as it is, and learn") {
    const Dataset& data = moving_ball();
    const Split& train = *data.find("train");
    Config config = tiny_spline(60);
    config.loss.tv_density = config.loss.tv_color = config.loss.tv_sh = config.loss.tv_control =
        config.loss.tv_rigidity = 0;
    config.radiance.sh_order = 3;
    config.radiance.sh_start = {0.3f, 0.75f, 0.85f};
    Trainer trainer(config, train, data.time_map);
    int order = 0, joined = 0;
    while (!trainer.done()) {
      const std::vector<char> state = trainer.save();
      const VoxelModel before = trainer.model();
      trainer.step();
      const int now = trainer.model().radiance.sh_order;
      if (now == order) continue;
      // The same step by a run that learns nothing: all that changes is what joins.
      Config idle = config;
      OptimiserConfig& o = idle.optimiser;
      o.lr_density = o.lr_color = o.lr_sh = o.lr_control = o.lr_rigidity = o.lr_light = o.lr_presence =
          o.lr_background = o.shrink = 0;
      Trainer other(idle, train, data.time_map);
      other.restore(state);
      other.step();
      const VoxelModel after = other.model();
      CHECK(before.radiance.sh_order == order);
      CHECK(after.radiance.sh_order == now);
      const Frame& f = train.frames[5];
      const auto seen = [&](const VoxelModel& m) { return render_image(m, f.camera, f.time).rgb.data; };
      CHECK(seen(after) == seen(before));
      order = now;
      ++joined;
    }
    CHECK(joined == 3);
    const VoxelModel model = trainer.model();
    float finest = 0;
    for (std::size_t r = kBrickRows; r < model.radiance.raw.topology->rows(); ++r)
      finest = std::max(finest, std::abs(model.radiance.raw.row(r)[4 + 12]));
    CHECK(finest > 0.01f);
  }
  TEST_CASE("a run without a refresh of its occupancy leaves no fog that no ray has sampled") {
    const Dataset& data = moving_ball();
    Config config = test::small_run(30);
    config.grid.radiance = {28};
    config.grid.radiance_start = {0};
    config.grid.motion = {4};
    config.grid.motion_start = {0};
    const VoxelModel model = test::trained(config, data);
    const SamplingConfig& s = config.sampling;
    const BitGrid matter = canonical_occupancy(model, s.occupancy_cells, s.occupancy_alpha, model.step);
    REQUIRE(matter.count() > 0);
    REQUIRE(matter.count() < matter.cells());
    const Channels& raw = model.radiance.raw;
    int fog = 0;
    for (int b = 1; b <= raw.topology->brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i)
        if (!matter.test(matter.index(matter.cell_of(raw.topology->position(b, i)))))
          fog += raw.row(std::size_t(b) * kBrickRows + i)[0] > kEmptyDensity;
    CHECK(fog == 0);
  }
  TEST_CASE("matter that is not visible is emptied, and pictures are as good without it") {
    Config config = preset("draft");
    config.run.max_time = 0;
    config.run.max_steps = 250;
    config.sampling.rays = 1024;
    config.grid.radiance = {24, 72};
    config.sampling.occupancy_cells = 32;
    config.grid.radiance_start = {0, 0.3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0.1f, 0.4f};
    const Dataset& data = moving_ball();
    const auto learned = [&](std::vector<float> when) {
      config.grid.empty_start = std::move(when);
      Trainer trainer(config, *data.find("train"), data.time_map);
      while (!trainer.done()) trainer.step();
      return trainer.model();
    };
    const auto matter = [](const VoxelModel& model) {
      int rows = 0;
      for (std::size_t r = kBrickRows; r < model.radiance.raw.topology->rows(); ++r)
        rows += model.radiance.raw.row(r)[0] > 2;
      return rows;
    };
    const VoxelModel full = learned({}), emptied = learned({0.598f, 0.8f});
    CAPTURE(matter(full));
    CAPTURE(matter(emptied));
    CHECK(matter(emptied) < 0.9 * matter(full));
    const Topology& bricks = *emptied.radiance.raw.topology;
    CHECK(bricks.brick_count() < full.radiance.raw.topology->brick_count());
    CHECK(int(bricks_above(emptied.radiance.raw, -10).size()) ==
          bricks.brick_count());  // nothing is kept for nothing
    CHECK(test::test_psnr(emptied, data) > test::test_psnr(full, data) - 0.5);

    // The state loses the bricks too, and goes on from before and after in the same bits.
    config.grid.empty_start = {0.598f, 0.8f};
    Trainer trainer(config, *data.find("train"), data.time_map);
    while (trainer.step().progress < 0.599) {
    }
    const std::vector<char> before = trainer.save();
    CHECK(trainer.step().stage_changed);
    const std::vector<char> after = trainer.save();
    CHECK(after.size() < before.size());
    for (const std::vector<char>* state : {&before, &after}) {
      Trainer again(config, *data.find("train"), data.time_map);
      again.restore(*state);
      while (!again.done()) again.step();
      const VoxelModel model = again.model();
      CHECK(model.radiance.raw.topology->bricks == bricks.bricks);
      CHECK(model.radiance.raw.values == emptied.radiance.raw.values);
    }
  }
}
