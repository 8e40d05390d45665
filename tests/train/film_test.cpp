// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/film/moving_part.hpp"
#include "train/film/still_world.hpp"
#include "train/film/unexplained.hpp"

using namespace splinevox;

namespace {

Config short_config() {
  Config c = preset("fast");
  c.run.max_time = 0;
  c.run.max_steps = 1600;
  c.run.find_ground = false;
  c.sampling.rays = 1024;
  return c;
}

SynthOptions orbit_of(double gloss = 0) {
  SynthOptions o{.frames = 40, .size = 64, .orbit = 0.5};
  o.look.gloss = gloss;
  return o;
}

/// A smooth pattern of stripes, moved by so many pixels.
Image stripes(float by) {
  Image out(40, 30, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < 3; ++c)
        out.pixel(x, y)[c] = 0.5f + 0.4f * std::sin(0.7f * (float(x) + by) + 0.3f * float(y) + float(c));
  return out;
}

Image blurred(const Image& picture) {
  Image out = picture;
  for (int y = 1; y + 1 < out.height; ++y)
    for (int x = 1; x + 1 < out.width; ++x)
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (int v = y - 1; v <= y + 1; ++v)
          for (int u = x - 1; u <= x + 1; ++u) sum += picture.pixel(u, v)[c];
        out.pixel(x, y)[c] = sum / 9;
      }
  return out;
}

void paint(Image& picture, int x0, int y0, int x1, int y1) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x)
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = c == 0 ? 1.0f : 0.0f;
}

double moving_share(const std::vector<CoarseMask>& masks) {
  double share = 0;
  for (const CoarseMask& m : masks) share += double(m.squares.count()) / double(m.squares.pixels());
  return share / double(masks.size());
}

}  // namespace

TEST_SUITE("train/film") {
  TEST_CASE("blur and a shift by a pixel explain a picture; something new in it is found as a whole") {
    const Image picture = stripes(0);
    const std::vector<char> known(40 * 30, 1);
    const auto found = [&](const Image& a, const Image& b) {
      return clear_errors(unexplained(a, b), known, 40, 30, 1).count();
    };
    CHECK(found(picture, picture) == 0);
    CHECK(found(picture, blurred(picture)) == 0);
    CHECK(found(blurred(picture), picture) == 0);
    CHECK(found(picture, stripes(0.9f)) == 0);
    Image with = picture;
    paint(with, 10, 8, 18, 16);
    const PixelMask mask = clear_errors(unexplained(with, picture), known, 40, 30, 1);
    CHECK(mask.count() > 40);  // of 64
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x)
        if (mask.test(x, y)) CHECK((x >= 9 && x < 19 && y >= 7 && y < 17));
    CHECK(found(picture, with) > 40);  // what is gone counts as well
    Image dot = picture;
    paint(dot, 20, 20, 21, 21);
    CHECK(found(dot, picture) == 0);
    // Of places that nothing is known of nothing is said, and in darker scenes less is clear.
    CHECK(clear_errors(unexplained(with, picture), std::vector<char>(40 * 30, 0), 40, 30, 1).count() == 0);
    CHECK(clear_errors(std::vector<float>(40 * 30, 0.03f), known, 40, 30, 1).count() == 0);
    CHECK(clear_errors(std::vector<float>(40 * 30, 0.03f), known, 40, 30, 0.5f).count() == 40 * 30);
  }

  TEST_CASE(
      "cells before which a few pictures in a row show motion may move, and those of its lines of sight") {
    Split film{"train", {}};
    std::vector<CoarseMask> moving;
    const Vec3d mover{0.3, 0.2, 0};
    Dataset around = make_synth("static", {.frames = 40, .size = 64, .orbit = 0.5});
    film.frames = around.find("train")->frames;
    for (Frame& f : film.frames) {
      CoarseMask mask{PixelMask(32, 32), 2};
      const Projection p = project(f.camera, mover);
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
          if (std::hypot(x + 0.5 - p.u / 2, y + 0.5 - p.v / 2) < 1.5)
            mask.squares.set(std::size_t(y * 32 + x));
      moving.push_back(mask);
    }
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    const BitGrid cells = cells_that_move(moving, film, box);
    REQUIRE(cells.cells() > 0);
    CHECK(cells.test(cells.index(cells.cell_of(cast<float>(mover)))));
    CHECK(double(cells.count()) < 0.2 * double(cells.cells()));
    CHECK_FALSE(cells.test(cells.index(cells.cell_of({-0.5f, -0.5f, 0}))));
    // Seen once, it may be anywhere on the ray: there is nothing in a row.
    std::vector<CoarseMask> once = moving;
    for (std::size_t f = 0; f < once.size(); ++f)
      if (f != 20 && f != 21) once[f].squares = PixelMask(32, 32);
    const BitGrid ray = cells_that_move(once, film, box);
    CHECK(ray.test(ray.index(ray.cell_of(cast<float>(mover)))));
    CHECK(ray.count() > 0);
    // Nothing moves: no cell is free, which is not the same as not to know.
    for (CoarseMask& m : once) m.squares = PixelMask(32, 32);
    CHECK(cells_that_move(once, film, box).cells() > 0);
    CHECK(cells_that_move(once, film, box).count() == 0);
    once[3] = {};
    CHECK(cells_that_move(once, film, box).cells() == 0);
    CHECK(cells_that_move({}, film, box).cells() == 0);
  }

  TEST_CASE(
      "a film of a static scene, matte or glossy, stays still; one of something that moves moves there") {
    const Config config = short_config();
    for (const double gloss : {0.0, 0.6}) {
      Dataset data = make_synth("static", orbit_of(gloss));
      const Prepared ready = prepare(config, data);
      REQUIRE(ready.effects.film);
      CAPTURE(ready.effects.film->share);
      CHECK_FALSE(ready.effects.film->moves());
      if (gloss == 0) CHECK_FALSE(ready.effects.film->unexplained());
      CHECK_FALSE(ready.used.has(Effect::motion));
      CHECK_FALSE(ready.used.has(Effect::light));
    }
    for (const char* scene : {"ball", "toy"}) {
      CAPTURE(scene);
      Dataset data = make_synth(scene, orbit_of());
      const Prepared ready = prepare(config, data);
      REQUIRE(ready.effects.film);
      CAPTURE(ready.effects.film->share);
      CHECK(ready.effects.film->unexplained());
      CHECK(ready.used.has(Effect::motion));
      CHECK(ready.config.sampling.changing == 0);
      CHECK(moving_share(ready.effects.moving) == doctest::Approx(ready.effects.film->share));
      for (std::size_t f = 0; f < data.find("train")->frames.size(); ++f)
        CHECK(data.find("train")->frames[f].moving == ready.effects.moving[f]);
    }
  }

  TEST_CASE(
      "a film that is trained too shortly for fits goes by the still world, unless nothing is to be tried") {
    Config config = short_config();
    config.run.max_steps = 300;
    const auto prepared = [&](const char* scene) {
      Dataset data = make_synth(scene, orbit_of());
      return prepare(config, data);
    };
    const Prepared still = prepared("static");
    CHECK(still.effects.verdicts.empty());
    CHECK_FALSE(still.used.has(Effect::motion));
    CHECK_FALSE(still.config.motion.enabled);
    CHECK(still.effects.note.find("too short a run") == 0);
    CHECK(still.effects.note.find("a still world shows all of the film") != std::string::npos);
    const Prepared moving = prepared("toy");
    CHECK(moving.used.has(Effect::motion));
    CHECK(moving.effects.note.find("a still world") == std::string::npos);
    config.effects.steps = 0;
    CHECK(prepared("static").used.has(Effect::motion));
  }

  TEST_CASE("what is known of a film is asked for neither of cameras that are anywhere nor without motion") {
    Config config = short_config();
    Dataset anywhere = make_synth("ball", {.frames = 20, .size = 32});
    CHECK_FALSE(prepare(config, anywhere, {.effects = EffectPolicy::keep}).effects.film);
    CHECK(anywhere.find("train")->frames[0].moving.empty());
    config.motion.enabled = false;
    Dataset film = make_synth("ball", orbit_of());
    CHECK_FALSE(prepare(config, film, {.effects = EffectPolicy::keep}).effects.film);
  }

  TEST_CASE("masks of what moves stand in for a still world, wherever cameras are") {
    Config config = short_config();
    config.effects.steps = 20;  // what moves is told
    for (const double orbit : {0.0, 0.5}) {
      CAPTURE(orbit);
      Dataset data = make_synth("toy", {.frames = 20, .size = 32, .orbit = orbit});
      Split& train = *data.find("train");
      for (Frame& f : train.frames) {
        f.moving = {PixelMask(32, 32), 1};
        for (std::size_t p = 0; p < 64; ++p) f.moving.squares.set(p);
      }
      for (std::size_t p = 0; p < 32 * 32; ++p) train.frames[3].moving.squares.set(p);  // has no mask
      const std::vector<CoarseMask> given = [&] {
        std::vector<CoarseMask> out;
        for (const Frame& f : train.frames) out.push_back(f.moving);
        return out;
      }();
      data.masks.emplace();
      data.masks->use = "moving";
      for (const EffectPolicy policy : {EffectPolicy::choose, EffectPolicy::keep}) {
        const Prepared ready = prepare(config, data, {.effects = policy});
        REQUIRE(ready.effects.film);
        CHECK(ready.effects.film->given);
        CHECK(ready.effects.film->moves());
        CHECK(ready.effects.film->share == doctest::Approx(64.0 / 1024));
        CHECK(ready.effects.film->pictures == 19);
        CHECK(ready.effects.moving.empty());
        CHECK(ready.used.has(Effect::motion));
        CHECK((ready.config.sampling.changing == 0) == (orbit > 0));
        for (std::size_t f = 0; f < given.size(); ++f) CHECK(train.frames[f].moving == given[f]);
      }
      for (Frame& f : train.frames) f.moving.squares = PixelMask(32, 32);
      const Prepared still = prepare(config, data);
      REQUIRE(still.effects.film);
      CHECK_FALSE(still.effects.film->unexplained());
      CHECK_FALSE(still.used.has(Effect::motion));
      data.masks.reset();  // what was found out before is no mask
      if (orbit == 0) CHECK_FALSE(prepare(config, data, {.effects = EffectPolicy::keep}).effects.film);
    }
  }

  TEST_CASE("a run that goes on knows what moves, though its pictures do not say so") {
    Config config = short_config();
    config.run.max_steps = 24;
    config.grid.radiance = {24, 32};
    config.sampling.occupancy_cells = 32;
    config.grid.radiance_start = {0, .4f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0, .2f};
    Dataset data = make_synth("toy", orbit_of());
    const Config ready = prepare(config, data, {.effects = EffectPolicy::keep}).config;
    const Split& told = *data.find("train");
    REQUIRE_FALSE(told.frames[0].moving.empty());
    Split untold = told;
    for (Frame& f : untold.frames) f.moving = {};
    const auto values = [](Trainer& trainer, int steps) {
      for (int i = 0; i < steps; ++i) trainer.step();
      const VoxelModel model = trainer.model();
      return std::vector<float>(model.radiance.raw.values.begin(), model.radiance.raw.values.end());
    };
    Trainer whole(ready, told, data.time_map), first(ready, told, data.time_map);
    const std::vector<float> want = values(whole, 24);
    values(first, 12);
    for (const Split* split : {static_cast<const Split*>(&untold), &told}) {
      Trainer second(ready, *split, data.time_map);
      second.restore(first.save());
      CHECK(values(second, 12) == want);
    }
    Trainer without(ready, untold, data.time_map);
    CHECK(values(without, 24) != want);

    // While the camera rests it is one that stands still. That says less than what is told of the whole film.
    Split rests = told;
    for (std::size_t f = 0; f < rests.frames.size(); ++f)
      if (f < rests.frames.size() / 3) {
        rests.frames[f].camera = rests.frames[0].camera;
        rests.frames[f].image = rests.frames[0].image;
      }
    Split named = rests;
    for (std::size_t f = 0; f < named.frames.size(); ++f)
      named.frames[f].camera_id = std::max(0, int(f) - int(named.frames.size() / 3) + 1);
    Trainer plain(ready, rests, data.time_map), rested(ready, named, data.time_map);
    const std::vector<float> same = values(plain, 24);
    values(rested, 12);
    for (Frame& f : named.frames) f.moving = {};
    Trainer on(ready, named, data.time_map);
    on.restore(rested.save());
    CHECK(values(on, 12) == same);
  }
}
