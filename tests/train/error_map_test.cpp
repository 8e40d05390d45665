// SPDX-License-Identifier: Apache-2.0
#include "train/error_map.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/rng.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/data/synth.hpp"
#include "train/batch.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

Split one_picture(int width, int height) {
  Split out;
  Frame frame;
  frame.image = Image16{width, height, std::vector<std::uint16_t>(std::size_t(4 * width * height), 65535)};
  out.frames.push_back(frame);
  return out;
}

/// Teaches that a block of a picture has an error of a size, in one channel of each of its four rays.
void teach(ErrorMap& map, std::uint32_t block, float error) {
  const std::vector<Patch> patch{{0, block}};
  const std::vector<Vec3> errors(4, Vec3{0, error, 0});
  map.learn(patch, errors);
}

/// Eight pictures of a ball, all of which are in every batch.
struct BallPictures {
  Dataset data = make_synth("ball", {.frames = 8, .size = 64, .seed = 2});
  const Split& train = *data.find("train");
  SceneBounds bounds = find_bounds(train, true, 48, 0.05f);
  SamplingConfig config;
  BallPictures() {
    config.frames = 8;
    config.rays = 32768;
    config.growth = 1;
    config.window = 1;
    config.carve = 0;
  }
};

TEST_CASE("a tile is drawn as often as the root of its squared error says, and its blocks evenly") {
  const int width = 45, height = 27;  // 23 x 14 blocks, so tiles at the edges are cut
  ErrorMap map(one_picture(width, height));
  const int along = 23, down = 14;
  CHECK_FALSE(map.draw(0).known());
  teach(map, 0, 0.1f);                               // first tile
  teach(map, std::uint32_t(13 * along + 22), 0.3f);  // last one, 3 x 2 blocks
  const ErrorDraw draw = map.draw(0);
  REQUIRE(draw.known());

  double sum = 0;
  for (std::uint32_t b = 0; b < std::uint32_t(along * down); ++b) sum += double(draw.chance(b));
  CHECK(sum == doctest::Approx(1));
  CHECK(draw.chance(0) == doctest::Approx(0.25 / 16));
  CHECK(draw.chance(std::uint32_t(13 * along + 22)) == doctest::Approx(0.75 / 6));
  CHECK(draw.chance(5) == 0);

  std::vector<int> met(std::size_t(along * down));
  constexpr int kDraws = 60000;
  const Rng rng(1, 1);
  for (int i = 0; i < kDraws; ++i)
    ++met[draw.block(rng.uniform(3 * std::uint64_t(i)), rng.uniform(3 * std::uint64_t(i) + 1),
                     rng.uniform(3 * std::uint64_t(i) + 2))];
  for (std::uint32_t b = 0; b < std::uint32_t(along * down); ++b) {
    const double expected = double(draw.chance(b)) * kDraws;
    CHECK(std::abs(met[b] - expected) <= 5 * std::sqrt(expected));
  }
}

TEST_CASE("numbers at the ends of [0, 1) stay within tiles that are known") {
  ErrorMap map(one_picture(64, 64));
  teach(map, 32 * 16 + 16, 0.2f);
  const ErrorDraw draw = map.draw(0);
  const float last = std::nextafter(1.0f, 0.0f);
  for (const float u : {0.0f, 0.5f, last})
    for (const float v : {0.0f, last}) CHECK(draw.chance(draw.block(u, v, v)) > 0);
}

TEST_CASE("newer errors count more, and patches that say nothing teach nothing") {
  ErrorMap map(one_picture(64, 64));
  teach(map, 0, 1);
  teach(map, 4, 1);
  for (int i = 0; i < 40; ++i) teach(map, 0, 0.5f);
  CHECK(map.draw(0).chance(0) / map.draw(0).chance(4) == doctest::Approx(0.5).epsilon(1e-3));
  const float before = map.draw(0).chance(0);
  map.learn(std::vector<Patch>{{0, 0, false}}, std::vector<Vec3>(4, Vec3{9, 9, 9}));
  CHECK(map.draw(0).chance(0) == before);
}

TEST_CASE("a set of many large pictures has a bounded map") {
  Split many = one_picture(64, 64);
  many.frames[0].image = Image16{4000, 3000, std::vector<std::uint16_t>(std::size_t(4) * 4000 * 3000, 0)};
  many.frames.resize(200, many.frames[0]);
  const ErrorMap map(many);
  CHECK(map.tiles() <= std::size_t(1) << 23);
  CHECK(map.tiles() > std::size_t(1) << 20);
  CHECK_FALSE(map.draw(199).known());
}

TEST_CASE("patches go where errors are, and weights undo it as far as is asked") {
  const BallPictures ball;
  const Split& train = ball.train;
  const SceneBounds& bounds = ball.bounds;
  SamplingConfig config = ball.config;
  ErrorMap map(train);
  Batch even, hard;
  const BatchSampler plain(train, bounds.box, config, 9);
  plain.draw(0, 1, 0.02f, {}, {}, even);
  for (const RayInput<float>& ray : even.rays) CHECK(ray.weight == 1);
  // The blocks of the upper half are fitted four times worse.
  const auto upper = [&](const Patch& p) { return p.block < 32 * 16; };
  for (const Patch& p : even.patches)
    map.learn(std::vector<Patch>{p}, std::vector<Vec3>(4, Vec3{upper(p) ? 0.4f : 0.1f, 0, 0}));
  const auto share = [&](const Batch& batch) {
    double above = 0, all = 0;
    for (std::size_t p = 0; p < batch.patches.size(); ++p) {
      const double w = double(batch.rays[4 * p].weight);
      all += w;
      if (upper(batch.patches[p])) above += w;
    }
    CHECK(all == doctest::Approx(double(batch.patches.size())));
    return above / all;
  };
  std::vector<double> shares;
  for (const float undo : {0.0f, 0.5f, 1.0f}) {
    SamplingConfig as = config;
    as.hard_undo = undo;
    BatchSampler(train, bounds.box, as, 9).draw(0, 1, 0.02f, {}, {}, hard, {}, {}, &map);
    shares.push_back(share(hard));
  }
  CHECK(shares[0] > share(even) + 0.08);
  CHECK(shares[1] < shares[0]);
  CHECK(shares[1] > shares[2]);
  CHECK(shares[2] == doctest::Approx(share(even)).epsilon(0.1));
}

TEST_CASE("weights undo what errors change also where more is drawn of what moves") {
  const BallPictures ball;
  const Split& train = ball.train;
  const SceneBounds& bounds = ball.bounds;
  SamplingConfig config = ball.config;
  config.hard_undo = 1;
  // What moves reaches across the lower left of every picture, in squares of an odd and of an even size.
  for (const int factor : {1, 3, 4})
    for (const float changing : {0.3f, 0.95f}) {
      CAPTURE(factor);
      CAPTURE(changing);
      config.changing = changing;
      std::vector<CoarseMask> moving(8, CoarseMask{PixelMask(64 / factor, 64 / factor), factor});
      const auto inside = [&](int x, int y) { return x < 40 && y >= 32; };
      for (CoarseMask& mask : moving)
        for (int y = 0; y < 64 / factor; ++y)
          for (int x = 0; x < 64 / factor; ++x)
            if (inside(x * factor, y * factor))
              mask.squares.set(std::size_t(y) * std::size_t(64 / factor) + x);
      BatchSampler sampler(train, bounds.box, config, 9);
      sampler.set_moving(moving, 0);
      ErrorMap map(train);
      Batch batch;
      sampler.draw(0, 1, 0.02f, {}, {}, batch);
      for (const Patch& p : batch.patches)
        map.learn(std::vector<Patch>{p}, std::vector<Vec3>(4, Vec3{p.block % 32 < 12 ? 0.4f : 0.1f, 0, 0}));
      // Shares of what moves, left and right, and of the rest.
      const auto shares = [&](const ErrorMap* errors) {
        std::array<double, 3> out{};
        double all = 0;
        for (int step = 1; step < 25; ++step) {
          sampler.draw(step, 1, 0.02f, {}, {}, batch, {}, {}, errors);
          for (std::size_t p = 0; p < batch.patches.size(); ++p) {
            const int x = int(batch.patches[p].block % 32) * 2, y = int(batch.patches[p].block / 32) * 2;
            const double w = double(batch.rays[4 * p].weight);
            out[!inside(x, y) ? 2 : x < 24 ? 0 : 1] += w;
            all += w;
          }
        }
        for (double& share : out) share /= all;
        return out;
      };
      const auto even = shares(nullptr), undone = shares(&map);
      for (std::size_t k = 0; k < 3; ++k) CHECK(undone[k] == doctest::Approx(even[k]).epsilon(0.015));
    }
}

}  // namespace
}  // namespace splinevox
