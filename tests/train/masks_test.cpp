// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <random>

#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/batch.hpp"
#include "train/bounds/ground.hpp"
#include "train/bounds/hull.hpp"

/// What ignored pixels hold must not matter, to the last bit.
namespace {

using namespace splinevox;

/// A rectangle and single pixels.
PixelMask some_pixels(int width, int height) {
  PixelMask mask(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if ((x > width / 2 && y < height / 2) || (x * 7 + y * 3) % 29 == 0)
        mask.set(std::size_t(y) * std::size_t(width) + std::size_t(x));
  return mask;
}

/// The moving ball with masks, and anything at all in the pixels that they ignore.
Dataset masked_ball(unsigned garbage, bool opaque) {
  Dataset data = make_synth("ball", {.frames = 12, .size = 32, .seed = 3});
  std::mt19937 rng(garbage);
  for (Split& split : data.splits)
    for (Frame& f : split.frames) {
      f.ignored = some_pixels(f.image.width, f.image.height);
      Image16 image = f.image.unpacked();
      for (std::size_t i = 0; i < image.pixels(); ++i) {
        std::uint16_t* p = image.rgba.data() + 4 * i;
        if (opaque && p[3] == 0) p[0] = p[1] = p[2] = std::uint16_t(20000 + 800 * (i % 31));
        if (f.ignored.test(i))
          for (int c = 0; c < 4; ++c) p[c] = std::uint16_t(rng() & 0xffff);
        if (opaque) p[3] = 65535;
      }
      f.image = image;
    }
  data.has_alpha = !opaque;
  return data;
}

Config masked_run(int steps) {
  Config c = test::small_run(steps);
  c.effects.steps = 10;
  c.sampling.rays = 512;
  return c;
}

struct PreparedRun {
  Prepared prepared;
  VoxelModel model;
};

PreparedRun prepared_run(Dataset data, int steps) {
  PreparedRun out;
  out.prepared = test::on_threads(2, [&] { return prepare(masked_run(steps), data); });
  out.model = test::trained(out.prepared.config, data);
  return out;
}

TEST_SUITE("train/masks") {
  TEST_CASE("what ignored pixels hold changes no bit of a model, nor of what is decided before") {
    for (const bool opaque : {false, true}) {
      CAPTURE(opaque);
      const PreparedRun a = prepared_run(masked_ball(1, opaque), 80),
                        b = prepared_run(masked_ball(2, opaque), 80);
      REQUIRE(a.prepared.effects.trials.size() == b.prepared.effects.trials.size());
      CHECK_FALSE(a.prepared.effects.trials.empty());
      for (std::size_t i = 0; i < a.prepared.effects.trials.size(); ++i)
        CHECK(a.prepared.effects.trials[i].psnr == b.prepared.effects.trials[i].psnr);
      CHECK(a.prepared.notes == b.prepared.notes);
      CHECK(a.model.radiance.raw.values == b.model.radiance.raw.values);
      REQUIRE(a.model.motion.levels.size() == b.model.motion.levels.size());
      for (std::size_t l = 0; l < a.model.motion.levels.size(); ++l)
        CHECK(a.model.motion.levels[l].values == b.model.motion.levels[l].values);
    }
  }

  TEST_CASE("no ray of an ignored pixel is drawn, and every other pixel has its turn") {
    Dataset data = make_synth("ball", {.frames = 3, .size = 9, .seed = 3});
    Split& split = *data.find("train");
    split.frames.resize(1);
    Frame& frame = split.frames[0];
    frame.ignored = some_pixels(frame.image.width, frame.image.height);
    frame.ignored.set(frame.image.pixels() - 1);  // the corner block has one pixel: none is left of it
    SamplingConfig config = masked_run(1).sampling;
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    const BatchSampler sampler(split, box, config, 1);
    std::vector<int> drawn(frame.image.pixels());
    Batch batch;
    for (int step = 0; step < 20; ++step) {
      sampler.draw(step, 1, 0.01f, Background{}, {}, batch);
      for (const RayInput<float>& ray : batch.rays) {
        const Projection p = project(frame.camera, frame.camera.position + cast<double>(ray.direction));
        ++drawn[std::size_t(p.v) * std::size_t(frame.image.width) + std::size_t(p.u)];
      }
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) CHECK((drawn[i] > 0) != frame.ignored.test(i));
  }

  TEST_CASE("ignored pixels neither carve the hull nor fill it") {
    Dataset data = make_synth("ball", {.frames = 24, .size = 48, .seed = 3});
    Split& train = *data.find("train");
    const SceneBounds whole = find_bounds(train, true, 32, 0.05f);
    for (std::size_t f = 0; f < train.frames.size(); f += 2) {  // half the pictures have a blind half
      Frame& frame = train.frames[f];
      frame.ignored = PixelMask(frame.image.width, frame.image.height);
      for (std::size_t i = 0; i < frame.image.pixels() / 2; ++i) frame.ignored.set(i);
    }
    const SceneBounds part = find_bounds(train, true, 32, 0.05f);
    CHECK(part.box.longest_edge() > 0.95f * whole.box.longest_edge());
    CHECK(part.box.longest_edge() < 1.6f * whole.box.longest_edge());
    CHECK(explained_by_hull(train, cameras_of(train)) > 0.95);
  }

  TEST_CASE("a plain ground is found beside what is ignored, and cut out up to it") {
    Dataset data = make_synth("ball", {.frames = 6, .size = 24, .seed = 3});
    Split& train = *data.find("train");
    for (Frame& frame : train.frames) {
      frame.ignored = PixelMask(frame.image.width, frame.image.height);
      Image16 image = frame.image.unpacked();
      for (std::size_t i = 0; i < image.pixels(); ++i) {
        std::uint16_t* p = image.rgba.data() + 4 * i;
        if (p[3] < 65535) p[0] = p[1] = p[2] = 65535;
        if (int(i) % image.width < image.width / 4) {  // something red along a side
          frame.ignored.set(i);
          p[0] = 65535;
          p[1] = p[2] = 0;
        }
        p[3] = 65535;
      }
      frame.image = image;
    }
    const std::optional<Vec3> ground = find_ground(train);
    REQUIRE(ground.has_value());
    CHECK(ground->y == doctest::Approx(1).epsilon(0.01));
    cut_ground(train, *ground);
    for (const Frame& frame : train.frames)
      for (const int y : {0, frame.image.height - 1})  // no ring is left beside it
        CHECK(frame.image.pixel(frame.image.width / 4, y)[3] == 0);
  }
}

}  // namespace
