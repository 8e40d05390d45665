// SPDX-License-Identifier: Apache-2.0
// Hard cases H22 to H26, H31 and H32 of docs/numerics.md: motion across leaves, optimiser, storage, sums,
// finite checks.
#include <doctest/doctest.h>

#include <limits>
#include <random>

#include "backend/host/optimiser.hpp"
#include "hard/measured.hpp"
#include "hard/scenes.hpp"
#include "math/schedule.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "support/blob_model.hpp"
#include "support/on_threads.hpp"
#include "support/tiny_dataset.hpp"
#include "train/learner.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

const Split& train() { return *ball().find("train"); }

Camera camera_at(Vec3d position, Vec3d shift = {}) {
  const Vec3d back = normalize(position), right = normalize(cross(Vec3d{0, 0, 1}, back));
  return {48, 48, 58, 58, 24, 24, {{right, cross(back, right), back}}, position + shift};
}

Channels noise(int cells, int width, unsigned seed) {
  const std::vector<float> zero(width, 0.0f);
  Channels c =
      make_channels(make_dense_topology(make_lattice({{-1, -1, -1}, {1, 1, 1}}, cells)), width, zero.data());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (std::size_t i = std::size_t(kBrickRows) * width; i < c.values.size(); ++i)
    c.values[i] = uniform(random);
  return c;
}

}  // namespace

TEST_SUITE("hard/storage") {
  TEST_CASE(
      "H22: an object that leaves its leaves does not vanish: control points are where it goes, not where it "
      "was") {
    // The blob travels through four leaves of 8 voxels; its bricks hold the place where it was at time 0
    // only.
    const BlobMotion motion{.shift = {-0.45f, 0, 0}};
    VoxelModel moving = blob_model(48, motion);
    const VoxelModel still = blob_model(48, {.moves = false});
    CHECK(0.45f / moving.radiance.raw.topology->lattice.spacing > kBrick);
    const Image there = render_image(moving, camera_at({2.5, 1.5, 1}), 1).rgb;
    const Image here = render_image(still, camera_at({2.5, 1.5, 1}, {-0.45, 0, 0}), 0).rgb;
    measured_least("H22 a ball moved by its own width against the ball seen from a moved camera",
                   psnr(there, here), 45, "dB");
    // A trained model: wherever a frame has matter, motion is stored.
    const VoxelModel& model = plain_model();
    const MotionField& m = model.motion;
    const OccupancyPyramid canonical(canonical_occupancy(model, 32, 0.1f, model.step));
    const BrickView<float> view(*m.levels[0].topology);
    std::size_t cells = 0, bare = 0;
    for (const Frame& f : train().frames) {
      const BitGrid grid = frame_occupancy(model, make_slice(m, stored_weights(m, f.time)), canonical);
      Int3 c;
      for (c.x = 0; c.x < grid.size.x; ++c.x)
        for (c.y = 0; c.y < grid.size.y; ++c.y)
          for (c.z = 0; c.z < grid.size.z; ++c.z) {
            if (!grid.test(grid.index(c))) continue;
            const Vec3 x = grid.center(c);
            const Cell at = view.cell(int(view.coordinate(x.x, 0)), int(view.coordinate(x.y, 1)),
                                      int(view.coordinate(x.z, 2)));
            ++cells;
            bare += view.rows(at).row[0] < kBrickRows;
          }
    }
    CHECK(cells > 1000);
    CHECK(bare == 0);
  }
  TEST_CASE(
      "H23: Adam's corrections are exact, moments never become subnormal, and what no ray saw does not "
      "drift") {
    Worst correction;
    for (const double beta : {0.9, 0.99, 0.999, 0.9999})
      for (const double t : {1., 2., 7., 100., 1e4, 1e6}) {
        const long double b = beta, exact = 1 / -std::expm1((long double)t * std::log(b));
        correction.see(double(std::abs(moment_factors(beta, beta, 1e-8, t).correction2 / exact - 1)) / kUnit);
        if (beta == 0.9999 && t == 1)
          CHECK(std::abs(1 / (1 - float(beta)) / exact - 1) > 1e-5L);  // 1 - beta in float
      }
    measured("H23 bias correction", correction.value, 1);

    Channels values = noise(7, 8, 1);
    const Channels before = values;
    Learner learner(values);
    Gradient gradient(values);
    std::fill(learner.rate.begin(), learner.rate.end(), 0.01f);
    const std::size_t seen = kBrickRows + 5;
    for (int step = 1; step <= 10000; ++step) {
      gradient.values.row(seen)[0] = step < 100 ? 1e-3f : 0;  // then touched, but without gradient
      gradient.touched[1].set(5);
      update(learned(values, learner), gradient, moment_factors(0.9, 0.99, 1e-8, step), 1);
    }
    std::size_t moved = 0, subnormal = 0;
    for (std::size_t i = 0; i < values.values.size(); ++i) {
      moved += i / 8 != seen && values.values[i] != before.values[i];
      for (const float x : {learner.m[i], learner.v[i]})
        subnormal += x != 0 && std::abs(x) < std::numeric_limits<float>::min();
    }
    CHECK(moved == 0);
    CHECK(subnormal == 0);
    CHECK(learner.m[seen * 8] == 0);
    CHECK(learner.v[seen * 8] == 0);
    CHECK(values.row(seen)[0] < before.row(seen)[0] - 0.5f);
  }
  TEST_CASE("H24: schedules begin and end exactly, and never leave the range") {
    for (const double end : {0.0, 1e-6, 0.02, 0.1, 1.0}) {
      CHECK(float(cosine_decay(0, end)) == 1.0f);
      CHECK(cosine_decay(1, end) == end);
      CHECK(cosine_decay(1 + 1e-9, end) == end);
      CHECK(cosine_decay(1e9, end) == end);
      double last = 2;
      for (int i = 0; i <= 1000; ++i) {
        const double rate = cosine_decay(i / 1000.0, end);
        CHECK(rate >= end);
        CHECK(rate <= last);
        last = rate;
      }
    }
    for (const double late_cost : {1.0, 3.6, 100.0})
      for (const double start : {0.0, 7.25, 60.0, 90.0}) {  // loading may have taken all there was
        CHECK(clock_progress(start, start, 60, late_cost) == (start < 60 ? 0 : 1));
        CHECK(clock_progress(60, start, 60, late_cost) == 1);
        CHECK(clock_progress(1e9, start, 60, late_cost) == 1);
        double last = 0;
        for (int i = 0; i <= 1000; ++i) {
          const double progress = clock_progress(0.06 * i, start, 60, late_cost);
          CHECK(progress >= last);
          CHECK(progress <= 1);
          last = progress;
        }
      }
    CHECK(clock_progress(35, 10, 60, 1) == doctest::Approx(0.5));
    CHECK(clock_progress(10 + 50 * (0.5 * 0.5 + 0.5 * 0.25), 10, 60, 3) == doctest::Approx(0.5));  // a = 1/2
    CHECK(clock_progress(10 + 50e-12, 10, 60, 3) == doctest::Approx(2e-12).epsilon(1e-9));
    Config c = short_run();
    c.run.max_steps = 0;
    CHECK_THROWS_AS(validate(c), Error);  // no end
    c.run.max_steps = 1;
    CHECK(finite(trained(c, train()).radiance.raw));
  }
  TEST_CASE("H25: a model stored in halves looks the same") {
    const TempFolder folder;
    const VoxelModel& model = plain_model();
    const std::string full = folder.str() + "/full.vdb", half = folder.str() + "/half.vdb";
    save_model(full, model);
    save_model(half, model, {}, true);
    const Split& held_out = *ball().find("test");
    const double before = quality(model, held_out), after = quality(load_model(half), held_out);
    measured("H25 PSNR lost by halves", before - after, 0.02, "dB");
    // And in floats it is the same picture, bit for bit.
    const VoxelModel back = load_model(full);
    Renderer a(model), b(back);
    for (const Frame& f : held_out.frames) {
      const Rendered x = a.render(f.camera, f.time), y = b.render(f.camera, f.time);
      CHECK(x.rgb.data == y.rgb.data);
      CHECK(x.depth.data == y.depth.data);
      CHECK(x.flow.data == y.flow.data);
    }
  }
  TEST_CASE("H26: sums are the same bits on 1, 2, 3, 4 and 7 threads, and again") {
    const auto losses = [](int threads) {
      return test::on_threads(threads, [] {
        Config config = short_run(8);
        config.loss.offset = 1e-3f;
        config.loss.divergence = 1e-3f;
        Trainer trainer(config, train(), {});
        std::vector<double> out;
        while (!trainer.done()) out.push_back(trainer.step().loss);
        return out;
      });
    };
    const std::vector<double> one = losses(1);
    for (const int threads : {1, 2, 3, 4, 7}) {
      CAPTURE(threads);
      CHECK(losses(threads) == one);
    }
  }
  TEST_CASE("H31: the finite check sees NaN, infinity and what has no square, in this very build") {
    Channels values = noise(7, 8, 2);
    for (const float bad : {std::nanf(""), INFINITY, -INFINITY, 1e17f, -3e38f}) {
      Gradient gradient(values);
      gradient.values.row(kBrickRows + 9)[3] = bad;
      CHECK(unusable_rows(gradient) == 0);  // a row that is not touched is not used
      gradient.touched[1].set(9);
      CHECK(unusable_rows(gradient) == 1);
      discard(gradient);
      CHECK(unusable_rows(gradient) == 0);
      CHECK_FALSE(gradient.touched[1].any());
      CHECK(gradient.values.row(kBrickRows + 9)[3] == 0);
    }
    Gradient gradient(values);
    gradient.values.row(kBrickRows + 9)[3] = 9e15f;
    gradient.touched[1].set(9);
    CHECK(unusable_rows(gradient) == 0);
  }
  TEST_CASE(
      "H31: a step without a finite gradient changes nothing; the fifth in a row ends the run with the "
      "reason") {
    // From the rays, and from the lattice alone: neither gradient has a square in float.
    bool from_rays = false;
    SUBCASE("offset loss") { from_rays = true; }
    SUBCASE("total variation") {}
    Config config = short_run(200);
    config.grid.motion_start = {0, 0.4f};
    config.loss.tv_share = 1;
    (from_rays ? config.loss.offset : config.loss.tv_density) = 1e30f;
    Trainer trainer(config, train(), {});
    // Total variation of the lattice before training is 0: there the first step still has a gradient.
    const int first = from_rays ? 1 : 2;
    if (!from_rays) CHECK_FALSE(trainer.step().discarded);
    const VoxelModel before = trainer.model();
    for (int step = first; step < first + 4; ++step) {
      const StepReport report = trainer.step();
      CHECK(report.discarded);
      CHECK(std::isnan(report.loss));
      CHECK(report.step == step);
      CHECK(trainer.model().radiance.raw.values == before.radiance.raw.values);
    }
    try {
      trainer.step();
      FAIL("went on without a gradient");
    } catch (const Error& error) {
      CHECK(error.fault == Fault::numeric);
      CHECK(std::string(error.what())
                .find("step " + std::to_string(first) + ": 5 steps in a row were not finite") == 0);
    }
    CHECK(trainer.model().radiance.raw.values == before.radiance.raw.values);
  }
  TEST_CASE("H32: an empty model, a lattice of one cell and a curve of two points") {
    VoxelModel model = blob_model(16, {.moves = false});
    model.radiance.raw =
        make_channels(make_topology(model.radiance.raw.topology->lattice, {}), model.radiance.raw.width,
                      std::vector<float>(model.radiance.raw.width, 0.0f).data());
    const Image empty = render_image(model, camera_at({2.5, 1.5, 1}), 0).rgb;
    for (const float v : empty.data) REQUIRE(v == 1);
    VoxelModel one = blob_model(1, {.moves = false});
    for (const float v : render_image(one, camera_at({2.5, 1.5, 1}), 0).rgb.data) REQUIRE(std::isfinite(v));
    Config config = short_run();
    config.motion.basis = BasisKind::bezier;
    config.motion.points = 2;
    measured_least("H32 two control points on a straight line of motion",
                   quality(trained(config, train()), *ball().find("test")), 26, "dB");
  }
}
