// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "backend/executors.hpp"
#include "render/field_view.hpp"
#include "support/blob_model.hpp"
#include "train/engine.hpp"
#include "train/optimiser.hpp"

using namespace splinevox;

namespace {

constexpr int kSlots = 3, kRays = 160;
constexpr float kShare = 0.5f;
constexpr std::uint64_t kDraw = 99;

/// A batch of rays through noise, with an occupancy that has holes.
struct Scene {
  VoxelModel model;
  Batch batch;
  std::vector<double> times{0.0, 0.35, 1.0};
  BitGrid occupied;
  RayLosses losses;

  Scene(int sh, bool moves, bool jet)
      : model(test::noisy_model(21, 6, FirstPoint::zero, BasisKind::bezier, sh, true, true)),
        occupied(model.box, 16) {
    if (!moves) model.motion.levels.clear();
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
        batch.targets.push_back({float(0.5 + 0.5 * uniform(random)), 0.4f, 0.9f});
        if (i % 4 == 0) batch.targets.back() = batch.rays.back().background;
        if (i % 8 == 3)
          batch.rays.back().background = {1.6f, 1.6f, 0.4f}, batch.targets.back() = {1, 0.7f, 1};  // clipped
      }
    }
    if (jet)
      losses.motion = {
          .offset = 0.02f, .offset_rigidity = 0.3f, .offset_softening = 1e-3f, .divergence = 0.03f};
    losses.min_weight = 1e-3f, losses.seen_share = 0.6f, losses.probe_seed = kDraw;
  }
};

Learner learner_of(const Channels& values, float tv) {
  Learner l(values);
  std::fill(l.tv.begin(), l.tv.end(), tv);
  return l;
}

/// One half of a level, which becomes zero.
void lay_to_rest(Channels& level, const BitGrid& occupied, ActiveRows& active) {
  const Topology& t = *level.topology;
  for (int b = 1; b <= t.brick_count(); ++b) {
    RowMask rests;
    for (int i = 0; i < kBrickRows; ++i)
      if (2 * t.vertex(b, i).y >= t.lattice.size.y) rests.set(i);
    rests.for_each(
        [&](int i) { std::fill_n(level.row(std::size_t(b) * kBrickRows + i), level.width, 0.0f); });
    active.rows[b] &= ~rests;
  }
  active.reach = reach_of(t, active.rows, occupied);
}

/// Largest difference of two gradients over the largest number of the first.
double apart(const AlignedVector<float>& a, const AlignedVector<float>& b) {
  REQUIRE(a.size() == b.size());
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, double(std::abs(a[i] - b[i]))), largest = std::max(largest, double(std::abs(a[i])));
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
    constexpr RestPrior kRest{.weight = 1e-2f, .softening = 1e-3f};
    for (const test::Runner& runner : test::runners()) {
      double worst = 0;
      for (int sh = -1; sh <= 3; ++sh)
        for (const int kind :
             {0, 1, 2, 3, 4})  // still; moving; with losses of motion; both with a part at rest
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
            Gradient none;
            ActiveRows active;
            if (moves)
              motion = learner_of(model.motion.levels[0], kTv),
              active.rows.assign(model.motion.levels[0].topology->bricks.size(), RowMask::all());
            if (kind > 2) lay_to_rest(model.motion.levels[0], scene.occupied, active);
            radiance.gradient.seen.assign(model.radiance.raw.topology->bricks.size(), {});
            std::vector<RowMask> seen = radiance.gradient.seen;
            std::vector<Vec3> behind(scene.batch.rays.size()), behind_on_device = behind;
            const PassResult pass =
                make_engine(sh, moves, losses)
                    ->run(model, active, model.step, scene.batch, scene.times,
                          {&scene.occupied, &scene.occupied, &scene.occupied}, scene.losses,
                          radiance.gradient, moves ? motion.gradient : none, behind);
            add_total_variation(model.radiance.raw, radiance, 1, kShare, kDraw);
            if (moves) {
              add_total_variation(model.motion.levels[0], motion, 1, kShare, kDraw + 1);
              add_curve_prior(model.motion.levels[0], motion, model.motion, kRest, kShare, kDraw + 1,
                              active.rows);
              add_curve_prior(model.motion.levels[0], motion, model.motion, kCurves, kShare, kDraw + 1);
            }

            // With beta1 = 0 the first moment after one step is the gradient.
            const auto learned = [](Channels& values, Learner& l) {
              return LearnedRows{&values, &l.m, &l.v, l.rate, l.tv, {}};
            };
            StepModel now{
                &model, learned(model.radiance.raw, radiance), {}, active.rows, {&scene.occupied, 1}};
            now.radiance.seen = seen;
            if (moves) now.levels.push_back(learned(model.motion.levels[0], motion));
            const std::vector<int> grids(kSlots, 0);
            StepInput in{};
            in.rays = scene.batch.rays, in.targets = scene.batch.targets, in.times = scene.times,
            in.occupancy = grids;
            in.losses = scene.losses;
            in.tv_scale = 1, in.tv_share = kShare, in.curves = kCurves, in.rest = kRest, in.draw = kDraw;
            in.factors = moment_factors(0, 0.99, 1e-8, 1);
            in.largest = kLargestGradient;
            in.behind = behind_on_device;
            const auto device = runner.step(deterministic);
            device->upload(now);
            const StepSums sums = device->run(in);
            device->download();

            CHECK(sums.bad_rays + sums.bad_rows == 0);
            CHECK(sums.samples == pass.samples);
            CHECK(sums.squared_error == doctest::Approx(pass.squared_error).epsilon(1e-5));
            CHECK(sums.motion_loss == doctest::Approx(pass.motion_loss).epsilon(1e-4));
            float largest = 0, off = 0;
            for (std::size_t i = 0; i < behind.size(); ++i)
              for (int c = 0; c < 3; ++c)
                largest = std::max(largest, std::abs(behind[i][c])),
                off = std::max(off, std::abs(behind[i][c] - behind_on_device[i][c]));
            CHECK(largest > 0);
            CHECK(off < 1e-5f * largest);
            int marked = 0, differs = 0;  // a weight next to the threshold may fall on either side of it
            for (std::size_t b = 1; b < seen.size(); ++b)
              for (int i = 0; i < kBrickRows; ++i)
                marked += seen[b].test(i), differs += seen[b].test(i) != radiance.gradient.seen[b].test(i);
            CHECK(marked > 200);
            CHECK(marked < int(seen.size()) * kBrickRows / 2);
            CHECK(differs <= 16);
            worst = std::max(worst, apart(radiance.gradient.values.values, radiance.m));
            CHECK(apart(radiance.gradient.values.values, radiance.m) < 1e-5);
            if (!moves) continue;
            worst = std::max(worst, apart(motion.gradient.values.values, motion.m));
            CHECK(apart(motion.gradient.values.values, motion.m) < 1e-5);
          }
      std::printf("%s: gradients differ from the CPU's by %.1e of the largest at most\n", runner.name.c_str(),
                  worst);
    }
  }
  TEST_CASE(
      "a ray shows the rows around its heaviest samples, and none where the picture has the colour of the "
      "background") {
    Scene scene(1, false, false);
    VoxelModel& model = scene.model;
    const auto marks = [&] {
      Gradient radiance(model.radiance.raw), none;
      radiance.seen.assign(model.radiance.raw.topology->bricks.size(), {});
      std::vector<Vec3> behind(scene.batch.rays.size());
      make_engine(1, false, false)
          ->run(model, {}, model.step, scene.batch, scene.times,
                {&scene.occupied, &scene.occupied, &scene.occupied}, scene.losses, radiance, none, behind);
      int marked = 0;
      for (const RowMask& brick : radiance.seen)
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
