// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "backend/step.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/film/moving_tracks.hpp"
#include "train/learn_tracks.hpp"

/// Points that are followed through the pictures of a film.
namespace {

using namespace splinevox;

SynthLook room_look() {
  SynthLook look;
  look.room = true;
  return look;
}

/// A film of a ball that flies through a room, held by hand.
Dataset hand_film(bool tracks, int frames = 16) {
  SynthOptions o{.frames = frames, .size = 40, .orbit = 0.12, .film = true, .shake = 0.03};
  o.tracks = tracks;
  o.look = room_look();
  return make_synth("ball", o);
}

Config followed_run(int steps) {
  Config c = test::small_run(steps);
  c.grid.radiance = {32};
  c.grid.radiance_start = {0};
  c.grid.motion = {16};
  c.grid.motion_start = {0};
  c.grid.box = {-3, -3, -1, 3, 3, 3};
  c.sampling.rays = 512;
  c.sampling.window = 1;
  return c;
}

/// Shares of the sightings of points that move, and of all others, in squares that are said to move.
std::pair<double, double> marked(const Dataset& data, const SynthScene& scene) {
  const Split& train = *data.find("train");
  const std::vector<char> moves = points_that_move(train);
  const int subjects = scene.at(0).subjects();
  double found = 0, movers = 0, wrong = 0, others = 0;
  for (const Frame& f : train.frames) {
    const PixelMask squares = squares_of_moving(f, moves, 1);
    const SynthMoment now = scene.at(f.time);
    for (int y = 0; y < f.camera.height; ++y)
      for (int x = 0; x < f.camera.width; ++x) {
        const auto hit = now.trace(camera_ray(f.camera, x + 0.5, y + 0.5));
        const bool ball = hit && hit->body < subjects;
        (ball ? movers : others) += 1;
        (ball ? found : wrong) += squares.test(x, y);
      }
  }
  return {found / movers, wrong / others};
}

/// Moves places by a normal deviation, pixels, and makes a share of the points wander.
void spoil(Dataset& data, double noise, double wrong) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  for (Frame& f : data.find("train")->frames)
    for (VisiblePoint& p : f.tracks) {
      const bool strays = double(unsigned(p.point) * 2654435761u) < wrong * 4294967296.0;
      p.u =
          std::clamp(p.u + float(noise + (strays ? 5 : 0)) * normal(random), 0.0f, float(f.camera.width) - 1);
      p.v = std::clamp(p.v + float(noise + (strays ? 5 : 0)) * normal(random), 0.0f,
                       float(f.camera.height) - 1);
    }
}

/// How far a surface point of the ball is from its own mean in the canonical volume, over the times of the
/// pictures; mean over points, scene units.
double canonical_spread(const VoxelModel& model, const SynthScene& scene, const Split& train) {
  const Frame& middle = train.frames[train.frames.size() / 2];
  const SynthMoment then = scene.at(middle.time);
  double spread = 0, points = 0;
  for (int y = 0; y < middle.camera.height; ++y)
    for (int x = 0; x < middle.camera.width; ++x) {
      const auto hit = then.trace(camera_ray(middle.camera, x + 0.5, y + 0.5));
      if (!hit || hit->body >= then.subjects()) continue;
      std::vector<Vec3d> places;
      Vec3d mean{};
      for (const Frame& f : train.frames) {
        const Vec3d p = cast<double>(scene.at(f.time).world_from_rest(hit->body, hit->rest));
        places.push_back(p + cast<double>(FrameSampler(model, f.time).warp(cast<float>(p)).displacement));
        mean += (1.0 / double(train.frames.size())) * places.back();
      }
      for (const Vec3d& p : places) spread += length(p - mean) / double(places.size());
      ++points;
    }
  return spread / points;
}

TEST_SUITE("train/tracks") {
  TEST_CASE("points of a ball move and those of the room do not, also by tracks that err") {
    const SynthScene scene = SynthScene::open("ball", room_look());
    Dataset data = hand_film(true);
    const auto [found, wrong] = marked(data, scene);
    CAPTURE(found);
    CAPTURE(wrong);
    CHECK(found > 0.8);
    CHECK(wrong < 0.05);
    spoil(data, 0.3, 0.1);
    const auto [found_still, wrong_more] = marked(data, scene);
    CAPTURE(found_still);
    CAPTURE(wrong_more);
    CHECK(found_still > 0.7);
    CHECK(wrong_more < 0.1);
  }

  TEST_CASE("rays of a batch's tracks: by slot, each point's at two moments or more, through its places") {
    const Dataset data = hand_film(true);
    const Split& train = *data.find("train");
    Batch batch;
    batch.frames = {3, 9, 14};
    batch.rays.resize(1024);
    const Box box{{-3, -3, -1}, {3, 3, 3}};
    TrackBatch drawn;
    const std::vector<char> all_move(8 * 24 * 24, 1);
    draw_tracks(train, batch, all_move, {}, box, 0.05f, drawn);
    REQUIRE(drawn.rays.size() >= 100);
    CHECK(drawn.rays.size() <= 1024 / 8 + 2);
    REQUIRE(drawn.first.back() == int(drawn.rays.size()));
    std::vector<int> slot_of(drawn.rays.size(), -1);
    int before = 0;
    for (const RayTask& task : drawn.tasks) {
      CHECK(task.first == before);
      for (int i = task.first; i < task.last; ++i) slot_of[std::size_t(i)] = task.slot;
      before = task.last;
    }
    CHECK(before == int(drawn.rays.size()));
    std::set<int> all(drawn.of_points.begin(), drawn.of_points.end());
    CHECK(all.size() == drawn.rays.size());
    const SynthScene scene = SynthScene::open("ball", room_look());
    for (std::size_t p = 0; p + 1 < drawn.first.size(); ++p) {
      CHECK(drawn.first[p + 1] - drawn.first[p] >= 2);
      // All of them meet the same point of the material.
      std::optional<Vec3d> rest;
      for (int k = drawn.first[p]; k < drawn.first[p + 1]; ++k) {
        const std::size_t i = std::size_t(drawn.of_points[std::size_t(k)]);
        const Frame& frame = train.frames[std::size_t(batch.frames[std::size_t(slot_of[i])])];
        const auto hit =
            scene.at(frame.time).trace({frame.camera.position, cast<double>(drawn.rays[i].direction)});
        REQUIRE(hit);
        if (rest) CHECK(length(hit->rest - *rest) < 0.02);
        rest = hit->rest;
      }
    }
    // Where it is known that nothing moves, nothing is learned of points.
    std::vector<CoarseMask> still;
    for (const Frame& f : train.frames) still.push_back({PixelMask(f.camera.width, f.camera.height), 1});
    draw_tracks(train, batch, all_move, still, box, 0.05f, drawn);
    CHECK(drawn.rays.empty());
  }

  TEST_CASE("no weight and no tracks are the same, to the last bit; tracks change the motion") {
    Config config = followed_run(20);
    const VoxelModel plain = test::trained(config, hand_film(false));
    const VoxelModel followed = test::trained(config, hand_film(true));
    CHECK(followed.motion.levels.back().values != plain.motion.levels.back().values);
    config.loss.tracks = 0;
    const VoxelModel unused = test::trained(config, hand_film(true));
    CHECK(unused.motion.levels.back().values == plain.motion.levels.back().values);
    CHECK(unused.radiance.raw.values == plain.radiance.raw.values);
  }

  TEST_CASE("tracks hold together in the canonical volume what they follow") {
    const SynthScene scene = SynthScene::open("ball", room_look());
    const Dataset data = hand_film(true);
    Config config = followed_run(80);
    const double followed = canonical_spread(test::trained(config, data), scene, *data.find("train"));
    config.loss.tracks = 0;
    const double plain = canonical_spread(test::trained(config, data), scene, *data.find("train"));
    CAPTURE(plain);
    CHECK(followed < 0.9 * plain);
  }

  TEST_CASE("points on ignored pixels say nothing and are not followed") {
    Dataset data = hand_film(true);
    Split& train = *data.find("train");
    const std::vector<char> all_move(points_that_move(train).size(), 1);
    for (Frame& f : train.frames) {
      CHECK(squares_of_moving(f, all_move, 1).count() > 0);
      f.ignored = PixelMask(40, 40);
      for (std::size_t i = 0; i < f.ignored.pixels(); ++i) f.ignored.set(i);
      CHECK(squares_of_moving(f, all_move, 1).count() == 0);
    }
    const std::vector<char> moves = points_that_move(train);
    CHECK(moves.size() == all_move.size());
    CHECK(std::count(moves.begin(), moves.end(), 1) == 0);
    Batch batch;
    batch.frames = {0, 1, 2};
    batch.rays.resize(512);
    TrackBatch drawn;
    draw_tracks(train, batch, all_move, {}, {{-3, -3, -1}, {3, 3, 3}}, 0.05f, drawn);
    CHECK(drawn.rays.empty());
  }

  TEST_CASE("the same bits for any number of threads, and across a stop") {
    const Config config = followed_run(12);
    const Dataset data = hand_film(true);
    Trainer whole(config, *data.find("train"), data.time_map);
    std::vector<char> at_7;
    while (!whole.done())
      if (whole.step().step == 7) at_7 = whole.save();
    const VoxelModel expected = whole.finish();
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      CHECK(test::trained(config, data).motion.levels.back().values == expected.motion.levels.back().values);
    }
    Trainer resumed(config, *data.find("train"), data.time_map);
    resumed.restore(at_7);
    while (!resumed.done()) resumed.step();
    CHECK(resumed.finish().motion.levels.back().values == expected.motion.levels.back().values);
  }

  TEST_CASE("a device that does not learn tracks says so before the first step") {
    const Dataset data = hand_film(true);
    const auto begin = [&](const Config& config) {
      Trainer(config, *data.find("train"), data.time_map, 0, nullptr, make_host_step(true));
    };
    Config config = followed_run(10);
    CHECK_THROWS_WITH_AS(begin(config), doctest::Contains("--device cpu"), Error);
    config.loss.tracks = 0;
    CHECK_NOTHROW(begin(config));
  }
}

}  // namespace
