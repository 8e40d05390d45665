// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "backend/background_gradient.hpp"
#include "backend/executors.hpp"
#include "backend/host/engine.hpp"
#include "backend/host/optimiser.hpp"
#include "render/field_view.hpp"
#include "support/blob_model.hpp"
#include "train/batch.hpp"
#include "train/learner.hpp"

using namespace splinevox;

namespace {

constexpr int kSlots = 3, kRays = 160;
constexpr float kShare = 0.5f;
constexpr std::uint64_t kDraw = 99;

/// A batch of rays through noise, with an occupancy that has holes.
struct Scene {
  VoxelModel model;
  Batch batch;
  std::vector<int> grids = std::vector<int>(kSlots, 0);
  BitGrid occupied;
  RayLosses losses;

  Scene(int sh, bool moves, bool jet)
      : model(test::noisy_model(21, 6, FirstPoint::zero, BasisKind::bezier, sh, true, true)),
        occupied(model.box, 16) {
    if (!moves) model.motion.levels.clear();
    model.background.order = 2;
    batch.times = {0.0, 0.35, 1.0};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (std::size_t i = 0; i < occupied.cells(); ++i)
      if (uniform(random) < 0.6) occupied.set(i);
    for (int f = 0; f < kSlots; ++f) {
      batch.frames.push_back(f);
      batch.tasks.push_back({f, f * kRays, (f + 1) * kRays});
      for (int i = 0; i < kRays; ++i) {
        const Ray ray{{2.5, uniform(random), uniform(random)},
                      normalize(Vec3d{-1, 0.3 * uniform(random), 0.3 * uniform(random)})};
        batch.rays.push_back(clip_ray(ray, model.box, model.step, 0.3f, Vec3{0.2f, 0.5f, 0.8f}));
        batch.rays.back().weight = 0.5f + 0.25f * float(i % 5);
        batch.targets.push_back({float(0.5 + 0.5 * uniform(random)), 0.4f, 0.9f});
        if (i % 4 == 0) batch.targets.back() = batch.rays.back().background;
        if (i % 8 == 3) {
          batch.rays.back().background = {1.6f, 1.6f, 0.4f};
          batch.targets.back() = {at_least(1.0f), 0.7f, at_least(1.0f)};
        }  // clipped
      }
    }
    if (jet)
      losses.motion = {
          .offset = 0.02f, .offset_rigidity = 0.3f, .offset_softening = 1e-3f, .divergence = 0.03f};
    losses.min_weight = 1e-3f;
    losses.transmittance = 0.2f;
    losses.visible_share = 0.6f;
    losses.probe_seed = kDraw;
  }

  StepInput input() const {
    StepInput in{};
    in.rays = batch.rays;
    in.targets = batch.targets;
    in.tasks = batch.tasks;
    in.times = batch.times;
    in.occupancy = grids;
    in.background = &model.background;
    in.losses = losses;
    in.tv_scale = 1;
    in.tv_share = kShare;
    in.draw = kDraw;
    in.factors = moment_factors(0, 0.99, 1e-8, 1);
    in.errors = in.slopes = true;
    return in;
  }
};

Learner learner_of(const Channels& values, float tv) {
  Learner l(values);
  std::fill(l.tv.begin(), l.tv.end(), tv);
  return l;
}

/// One half of a level, which becomes zero.
void freeze_half(Channels& level, const BitGrid& occupied, ActiveRows& active) {
  const Topology& t = *level.topology;
  for (int b = 1; b <= t.brick_count(); ++b) {
    RowMask frozen;
    for (int i = 0; i < kBrickRows; ++i)
      if (2 * t.vertex(b, i).y >= t.lattice.size.y) frozen.set(i);
    frozen.for_each(
        [&](int i) { std::fill_n(level.row(std::size_t(b) * kBrickRows + i), level.width, 0.0f); });
    active.rows[b] &= ~frozen;
  }
  active.reach = reach_of(t, active.rows, occupied);
}

/// Largest difference of two gradients over the largest number of the first.
double apart(const AlignedVector<float>& a, const AlignedVector<float>& b) {
  REQUIRE(a.size() == b.size());
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, double(std::abs(a[i] - b[i])));
    largest = std::max(largest, double(std::abs(a[i])));
  }
  REQUIRE(largest > 0);
  return most / largest;
}

}  // namespace

TEST_SUITE("backend/gradient") {
  TEST_CASE(
      "a device's gradients are the CPU's to 1e-5 of the largest, for every kernel, with total variation and "
      "the priors on curves") {
    constexpr float kTv = 1e-3f;
    constexpr CurvePrior kCurves{
        .length = 1e-2f, .scalar = {2e-2f}, .lane = {3}, .knots = 1e-2f, .spacing = 2, .softening = 1e-3f};
    constexpr StaticPrior kStaticPrior{.weight = 1e-2f, .softening = 1e-3f};
    for (const test::Runner& runner : test::runners()) {
      double worst = 0;
      for (int sh = -1; sh <= 3; ++sh)
        for (const int kind :
             {0, 1, 2, 3, 4})  // static; moving; with losses of motion; both with a frozen part
          for (const bool deterministic : {false, true}) {
            CAPTURE(runner.name);
            CAPTURE(sh);
            CAPTURE(kind);
            CAPTURE(deterministic);
            const bool losses = kind == 2 || kind == 4;
            Scene scene(sh, kind > 0, losses);
            VoxelModel& model = scene.model;
            const bool moves = kind > 0;
            Learner radiance = learner_of(model.radiance.raw, kTv), motion;
            Gradient d_radiance(model.radiance.raw), d_motion;
            ActiveRows active;
            if (moves) {
              motion = learner_of(model.motion.levels[0], kTv);
              d_motion = Gradient(model.motion.levels[0]);
              active.rows.assign(model.motion.levels[0].topology->bricks.size(), RowMask::all());
            }
            if (kind > 2) freeze_half(model.motion.levels[0], scene.occupied, active);
            std::vector<RowMask> before(model.radiance.raw.topology->bricks.size());  // visible rows
            for (std::size_t b = 1; b < before.size(); ++b)
              for (int i = 0; i < kBrickRows; ++i)
                if (hash64(b * kBrickRows + std::size_t(i)) % 4 == 0) before[b].set(i);
            std::vector<RowMask> visible(before.size()), visible_on_device = before;
            std::vector<Vec3> behind(scene.batch.rays.size()), errors(behind.size());
            std::vector<double> slopes(kSlots);

            StepModel now{};
            now.model = &model;
            now.radiance = learned(model.radiance.raw, radiance);
            if (moves) now.levels.push_back(learned(model.motion.levels[0], motion));
            now.active = &active;
            now.occupancy = {&scene.occupied, 1};
            now.curves = kCurves;
            now.static_prior = kStaticPrior;
            const StepInput in = scene.input();
            const Channels* level = moves ? &model.motion.levels[0] : nullptr;
            const PassResult pass = make_engine(sh, moves, losses)
                                        ->run(now, level, in, {scene.batch.tasks, {}}, d_radiance,
                                              moves ? &d_motion : nullptr, {behind, errors, slopes, visible});
            add_total_variation(model.radiance.raw, radiance.tv, 1, kShare, kDraw, before, d_radiance);
            if (moves) {
              add_total_variation(*level, motion.tv, 1, kShare, kDraw + 1, {}, d_motion);
              add_curve_prior(*level, model.motion, kStaticPrior, kShare, kDraw + 1, active.rows, d_motion);
              add_curve_prior(*level, model.motion, kCurves, kShare, kDraw + 1, {}, d_motion);
            }
            const BackgroundGradient d_background =
                background_gradient(model.background, scene.batch.rays, scene.batch.tasks, behind);

            // With beta1 = 0 the first moment after one step is the gradient.
            now.radiance.visible = visible_on_device;
            const auto device = runner.step(deterministic);
            device->upload(now);
            const StepSums sums = device->run(in);
            device->download();

            CHECK(sums.usable);
            CHECK(sums.samples == pass.samples);
            CHECK(sums.squared_error == doctest::Approx(pass.squared_error).epsilon(1e-5));
            CHECK(sums.motion_loss == doctest::Approx(pass.motion_loss).epsilon(1e-4));
            double largest = 0, off = 0;
            for (int j = 0; j < model.background.count(); ++j)
              for (int c = 0; c < 3; ++c) {
                largest = std::max(largest, std::abs(d_background[j][c]));
                off = std::max(off, std::abs(d_background[j][c] - sums.background[j][c]));
              }
            CHECK(largest > 0);
            CHECK(off < 1e-5 * largest);
            REQUIRE(sums.errors.size() == errors.size());
            for (std::size_t i = 0; i < errors.size(); ++i)
              for (int c = 0; c < 3; ++c) CHECK(std::abs(sums.errors[i][c] - errors[i][c]) < 1e-5);
            REQUIRE(sums.slopes.size() == slopes.size());
            double steepest = 0;
            for (const double slope : slopes) steepest = std::max(steepest, std::abs(slope));
            CHECK((steepest > 0) == moves);
            for (int s = 0; s < kSlots; ++s) CHECK(std::abs(sums.slopes[s] - slopes[s]) <= 1e-5 * steepest);
            int marked = 0, lost = 0;
            int differs = 0;  // a weight next to the threshold may fall on either side of it
            for (std::size_t b = 1; b < visible.size(); ++b)
              for (int i = 0; i < kBrickRows; ++i) {
                marked += visible[b].test(i);
                differs += !before[b].test(i) && visible[b].test(i) != visible_on_device[b].test(i);
                lost += before[b].test(i) && !visible_on_device[b].test(i);
              }
            CHECK(marked > 200);
            CHECK(marked < int(visible.size()) * kBrickRows / 2);
            CHECK(lost == 0);
            CHECK(differs <= 12);  // of three quarters of the rows
            worst = std::max(worst, apart(d_radiance.values.values, radiance.m));
            CHECK(apart(d_radiance.values.values, radiance.m) < 1e-5);
            if (!moves) continue;
            worst = std::max(worst, apart(d_motion.values.values, motion.m));
            CHECK(apart(d_motion.values.values, motion.m) < 1e-5);
          }
      std::printf("%s: gradients differ from the CPU's by %.1e of the largest at most\n", runner.name.c_str(),
                  worst);
    }
  }
  TEST_CASE(
      "a ray makes the rows around its heaviest samples visible, and none where the picture has the colour "
      "of the "
      "background") {
    Scene scene(1, false, false);
    VoxelModel& model = scene.model;
    const auto marks = [&] {
      Gradient radiance(model.radiance.raw);
      const ActiveRows none;
      std::vector<RowMask> visible(model.radiance.raw.topology->bricks.size());
      StepModel now{};
      now.model = &model;
      now.radiance.values = &model.radiance.raw;
      now.active = &none;
      now.occupancy = {&scene.occupied, 1};
      make_engine(1, false, false)
          ->run(now, nullptr, scene.input(), {scene.batch.tasks, {}}, radiance, nullptr, {.marks = visible});
      int marked = 0;
      for (const RowMask& brick : visible)
        for (int i = 0; i < kBrickRows; ++i) marked += brick.test(i);
      return marked;
    };
    CHECK(marks() > 200);
    for (std::size_t i = 0; i < scene.batch.rays.size(); ++i)
      scene.batch.targets[i] = scene.batch.rays[i].background;
    CHECK(marks() == 0);
    for (int i = 0; i < 16; ++i) scene.batch.targets[i].z += 0.02f;  // some of them pass through the box
    CHECK(marks() >= kCorners);
  }
}
