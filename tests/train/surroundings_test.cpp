// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "field/outer_walk.hpp"
#include "math/adam.hpp"
#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/learn_surroundings.hpp"
#include "train/start.hpp"

using namespace splinevox;

namespace {

constexpr double kWall = 6;  ///< half an edge of the room; the ball's cameras are some 4 from the middle

/// Where a ray from within meets the walls of the room, and their colour there.
Vec3 wall(const Ray& ray) {
  double leave = 1e300;
  for (int a = 0; a < 3; ++a)
    leave = std::min(leave, (std::copysign(kWall, ray.direction[a]) - ray.origin[a]) / ray.direction[a]);
  const Vec3d x = ray.origin + leave * ray.direction;
  return {float(0.5 + 0.35 * std::sin(1.3 * x.x + 0.4 * x.z)), float(0.5 + 0.35 * std::cos(1.1 * x.y)),
          float(0.5 + 0.3 * std::sin(0.9 * x.z - x.y))};
}

Config room_run(int steps, int surroundings) {
  Config c = test::small_run(steps);
  c.run.surroundings = surroundings > 0;
  c.grid.surroundings = {std::max(8, surroundings / 2), std::max(8, surroundings)};
  c.grid.surroundings_start = {0, .3f};
  c.grid.box = {-1.5f, -1.5f, -1.5f, 1.5f, 1.5f, 1.5f};
  return c;
}

Surroundings random_surroundings(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Surroundings out;
  out.box = {{-1, -2, -1}, {1, 2, 3}};
  out.shift = -3;
  const float row[OuterWalk::kWidth] = {};
  out.raw = make_channels(outer_topology(12), OuterWalk::kWidth, row);
  for (float& v : out.raw.values) v = normal(random);
  return out;
}

float largest(const Vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

TEST_SUITE("train/surroundings") {
  TEST_CASE("a ray meets the surroundings where it leaves the box of each size") {
    const Box box{{-1, -2, -1}, {1, 2, 3}};  // middle (0, 0, 1), half edges (1, 2, 2)
    const Ray from_middle{{0, 0, 1}, {1, 0, 0}};
    for (const float s : {0.0f, 0.25f, 0.5f, 0.9f}) {
      const OuterRay::Place p = OuterRay(box, from_middle).at(s);
      REQUIRE(p.met);
      CHECK(p.at.x == doctest::Approx(1 + s));  // at v = 1 / (1 - s): 2 - 1 / v
      CHECK(p.at.y == 0);
    }
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200; ++i) {
      const Ray ray{{3 * normal(random), 3 * normal(random), 3 * normal(random)},
                    normalize(Vec3d{normal(random), normal(random), normal(random)})};
      bool met = false;
      for (int k = 0; k < 20; ++k) {
        const float s = float(k) / 20;
        const OuterRay::Place p = OuterRay(box, ray).at(s);
        CHECK((p.met || !met));  // what is met at one size is met at all larger ones
        met = p.met;
        if (p.met) CHECK(largest(p.at) == doctest::Approx(1 + s).epsilon(1e-4));
      }
    }
    // Behind the camera, and past the box of a size: not met. Along a face there is no direction to divide
    // by.
    CHECK_FALSE(OuterRay(box, {{5, 0, 1}, {1, 0, 0}}).at(0.5f).met);
    CHECK_FALSE(OuterRay(box, {{-9, 3, 1}, {1, 0, 0}}).at(0).met);
    CHECK(OuterRay(box, {{-9, 3, 1}, {1, 0, 0}}).at(0.5f).met);
  }

  TEST_CASE("the gradient is that of differences") {
    Surroundings around = random_surroundings(1);
    const Vec3 far{0.2f, 0.9f, 0.4f}, g{0.7f, -0.4f, 1.1f};
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    int compared = 0;
    for (int i = 0; i < 40; ++i) {
      const Ray ray{{2 * normal(random), 2 * normal(random), 2 * normal(random)},
                    normalize(Vec3d{normal(random), normal(random), normal(random)})};
      OuterWalk walk(around);
      walk.forward(ray, far);
      struct Asked {
        std::int32_t row;
        float d[4];
      };
      std::vector<Asked> asked;
      const BrickView<float> view(*around.raw.topology);
      // The row of one corner of one sample, which other samples may read too.
      std::vector<float> sums(around.raw.topology->rows() * 4, 0.0f);
      walk.backward(far, g, [&](const OuterWalk::Sample& s, const EmissionAdjoint<float>& d) {
        float w[kCorners];
        trilinear_weights(s.fraction, w);
        const CellRows rows = view.rows(s.cell);
        for (int c = 0; c < kCorners; ++c) {
          float* sum = sums.data() + 4 * std::size_t(rows.row[c]);
          sum[0] += w[c] * d.density;
          for (int k = 0; k < 3; ++k) sum[1 + k] += w[c] * d.color[k];
        }
      });
      if (walk.count == 0) continue;
      const std::int32_t row = view.rows(walk.samples[walk.count / 3].cell).row[3];
      for (int k = 0; k < 4 && row >= kBrickRows; ++k) {
        float& value = around.raw.row(std::size_t(row))[k];
        const float kept = value, h = 2e-2f;
        value = kept + h;
        const float up = dot(g, OuterWalk(around).forward(ray, far));
        value = kept - h;
        const float down = dot(g, OuterWalk(around).forward(ray, far));
        value = kept;
        CHECK(sums[4 * std::size_t(row) + std::size_t(k)] ==
              doctest::Approx((up - down) / (2 * h)).epsilon(0.02).scale(0.02));
        ++compared;
      }
    }
    CHECK(compared > 40);
  }

  TEST_CASE("a background is given the gradient that surroundings let through") {
    Surroundings around = random_surroundings(4);
    const Background background;
    const Vec3 d{0.5f, -1, 2};
    std::mt19937 random(6);
    std::normal_distribution<double> normal;
    std::vector<Ray> rays;
    std::vector<float> through;
    for (int i = 0; i < 300; ++i) {
      rays.push_back({{normal(random), normal(random), normal(random)},
                      normalize(Vec3d{normal(random), normal(random), normal(random)})});
      OuterWalk walk(around);
      const Vec3 near = walk.forward(rays.back(), {}), far = walk.forward(rays.back(), {1, 1, 1});
      CHECK(walk.transmittance == doctest::Approx(far.x - near.x).epsilon(1e-4).scale(1));
      through.push_back(walk.transmittance);
    }
    std::vector<Vec3> behind(rays.size(), d);
    behind[7] = 1e-5f * d;  // too faint to be walked
    StepInput in{};
    in.factors = moment_factors(0, 0.99, 1e-8, 1);
    in.tv_scale = in.tv_share = in.radiance_rate = 1;
    const Config config;
    SurroundingsLearner(config, around).step(config, rays, behind, background, in, around);
    for (std::size_t i = 0; i < rays.size(); ++i)
      for (int c = 0; c < 3; ++c) CHECK(behind[i][c] == (i == 7 ? 0.0f : through[i] * d[c]));
  }

  TEST_CASE("a room around the box is learned, and the scene before it") {
    const Dataset data = test::ball_before(wall, 40, 40);
    const VoxelModel with = test::trained(room_run(250, 32), data),
                     without = test::trained(room_run(250, 0), data);
    REQUIRE(with.surroundings.any());
    CHECK_FALSE(without.surroundings.any());
    const double around = test::test_psnr(with, data), plain = test::test_psnr(without, data);
    MESSAGE("test split: " << around << " dB with surroundings, " << plain << " dB with a background alone");
    CHECK(around > plain + 3);
    CHECK(with.surroundings.raw.topology->brick_count() <= outer_topology(32)->brick_count());
  }

  TEST_CASE("there are none behind pictures with alpha, and none without a learned background") {
    Config config = room_run(3, 32);
    CHECK_FALSE(test::trained(config, make_synth("ball", {.frames = 12, .size = 24})).surroundings.any());
    config.run.background_order = -1;
    CHECK_FALSE(test::trained(config, test::ball_before(wall, 12, 24)).surroundings.any());
  }

  TEST_CASE("the same bits for any number of threads, and across a stop") {
    const Dataset data = test::ball_before(wall, 12, 24);
    const Config config = room_run(40, 24);
    const VoxelModel one = test::trained(config, data, 1), two = test::trained(config, data, 2);
    REQUIRE(one.surroundings.any());
    CHECK(one.surroundings.raw.values == two.surroundings.raw.values);
    CHECK(one.radiance.raw.values == two.radiance.raw.values);
    Trainer first(config, *data.find("train"), data.time_map);
    for (int i = 0; i < 25; ++i) first.step();  // bricks were dropped before
    Trainer second(config, *data.find("train"), data.time_map);
    second.restore(first.save());
    while (!second.done()) second.step();
    CHECK(second.model().surroundings.raw.values == one.surroundings.raw.values);
    CHECK(second.model().radiance.raw.values == one.radiance.raw.values);
  }
}

TEST_SUITE("train/places") {
  TEST_CASE("few places of cameras that stand still ask for more total variation, others for none") {
    Config config;
    PictureStats stats;
    stats.places = 8;
    stats.pictures = 192;
    CHECK(for_places(stats, config).loss.tv_density == doctest::Approx(12 * config.loss.tv_density));
    CHECK(for_places(stats, config).loss.tv_share > 3 * config.loss.tv_share);
    CHECK(for_places(stats, config).loss.tv_color == config.loss.tv_color);
    stats.places = 1;
    CHECK(for_places(stats, config).loss.tv_density == doctest::Approx(16 * config.loss.tv_density));
    stats.places = 150;  // one camera a moment: a hundred places more than it needs
    CHECK(for_places(stats, config).loss.tv_density == config.loss.tv_density);
    stats.places = 8;
    config.loss.tv_places = 0;
    CHECK(for_places(stats, config).loss.tv_density == config.loss.tv_density);
    CHECK(for_places(stats, config).loss.tv_share == config.loss.tv_share);
  }

  TEST_CASE("what few places show gets no finer cells than few_cells, other scenes all stages") {
    Config config;
    config.grid.few_cells = 96;
    PictureStats stats;
    stats.places = 8;
    stats.pictures = 192;
    for (const bool see_through : {false, true}) {
      stats.see_through = see_through;
      const GridConfig few = for_places(stats, config).grid;
      CHECK(few.radiance == std::vector<int>{40, 64, 96});
      REQUIRE(few.radiance_start.size() == 3);
      CHECK(few.radiance_start[0] == 0);
      CHECK(few.radiance_start[2] == doctest::Approx(0.55));  // the last one does not begin at 35% already
      CHECK(few.radiance_start[1] == doctest::Approx(0.15 * 0.55 / 0.35));
    }
    stats.places = 150;
    CHECK(for_places(stats, config).grid.radiance == config.grid.radiance);
    stats.places = 8;
    config.grid.few_cells = 0;
    CHECK(for_places(stats, config).grid.radiance == config.grid.radiance);
    config.grid.few_cells = 8;
    CHECK(for_places(stats, config).grid.radiance == std::vector<int>{40});  // one stage is always left
  }

  TEST_CASE("places are counted by pose") {
    Dataset data = make_synth("ball", {.frames = 12, .size = 16});
    Split train = *data.find("train");
    CHECK(picture_stats(train).places == 12);
    CHECK_FALSE(picture_stats(train).rig());
    for (std::size_t i = 0; i < train.frames.size(); ++i) train.frames[i].camera = train.frames[i % 3].camera;
    CHECK(picture_stats(train).places == 3);
    CHECK(picture_stats(train).rig());
    // Numbers that a program rounded anew for every picture are one place, if one camera took them.
    for (std::size_t i = 0; i < train.frames.size(); ++i)
      train.frames[i].camera.position.x += 1e-9 * double(i);
    CHECK(picture_stats(train).places == 12);
    for (std::size_t i = 0; i < train.frames.size(); ++i) train.frames[i].camera_id = int(i % 3);
    CHECK(picture_stats(train).places == 3);
  }

  TEST_CASE("opaque pictures begin with more matter than pictures with alpha") {
    const Config config;
    PictureStats stats;
    CHECK(initial_alpha(config, stats) == config.radiance.opaque_alpha);
    stats.see_through = true;
    CHECK(initial_alpha(config, stats) == config.radiance.initial_alpha);
  }

  TEST_CASE("surroundings that are asked for and not learned leave as much matter to begin with") {
    Config config;
    config.run.surroundings = true;
    config.grid.surroundings = {16};
    config.run.background_order = 0;
    CHECK(initial_alpha(config, PictureStats{}) == config.radiance.initial_alpha);
    config.run.background_order = -1;
    CHECK(initial_alpha(config, PictureStats{}) == config.radiance.opaque_alpha);
  }
}
