// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/batch.hpp"
#include "train/effects/still_proof.hpp"
#include "train/still/changing_cells.hpp"

using namespace splinevox;

namespace {

SynthOptions rig(bool turns = false) {
  return {.frames = turns ? 30 : 10, .size = 40, .rig = {.cameras = 5, .turns = turns}};
}

const Split& train_of(const Dataset& data) { return *data.find("train"); }

double mean_share(const Split& split) {
  const StillProof proof = prove(split);
  return proof.evidence ? proof.evidence->share : -1;
}

/// Of no known camera.
Split nameless(Split split) {
  for (Frame& f : split.frames) f.camera_id = -1;
  return split;
}

StillVerdict verdict_on(const Split& split) {
  const StillProof proof = prove(split);
  return proof.evidence ? proof.evidence->verdict : StillVerdict::unsure;
}

/// The split with pictures that a worse camera took.
/// @param change  of a value at u, v (pixels, anywhere) of channel c: reads the true picture, [0, 1]
using Reader = std::function<double(double u, double v, int c)>;
Split retaken(const Split& split,
              const std::function<double(const Reader&, int frame, int x, int y, int c)>& take) {
  Split out = split;
  for (std::size_t f = 0; f < out.frames.size(); ++f) {
    const Image16 in = split.frames[f].image.unpacked();
    Image16 made = in;
    const Reader read = [&](double u, double v, int c) {
      const int x = int(std::floor(u)), y = int(std::floor(v));
      const auto at = [&](int a, int b) {
        return in.pixel(std::clamp(a, 0, in.width - 1), std::clamp(b, 0, in.height - 1))[c] / 65535.0;
      };
      const double a = u - x, b = v - y;
      return (1 - b) * ((1 - a) * at(x, y) + a * at(x + 1, y)) +
             b * ((1 - a) * at(x, y + 1) + a * at(x + 1, y + 1));
    };
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x)
        for (int c = 0; c < 3; ++c)
          made.rgba[(std::size_t(y) * std::size_t(in.width) + std::size_t(x)) * 4 + std::size_t(c)] =
              std::uint16_t(257 * std::lround(255 * std::clamp(take(read, int(f), x, y, c), 0.0, 1.0)));
    out.frames[f].image = Picture(made);
  }
  return out;
}

/// Gains, noise and shifts that change from picture to picture.
Split worse(const Split& split, double noise, double flicker, double shake) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  std::vector<std::array<double, 3>> of_frame(split.frames.size());
  for (auto& f : of_frame) f = {1 + flicker * normal(rng), shake * normal(rng), shake * normal(rng)};
  return retaken(split, [&](const Reader& read, int f, int x, int y, int c) {
    const auto& [gain, dx, dy] = of_frame[std::size_t(f)];
    return gain * read(x + dx, y + dy, c) + noise * normal(rng);
  });
}

Config rig_choice() {
  Config c = preset("draft");
  c.run.max_time = 0;
  c.run.max_steps = 4000;
  c.effects.steps = 12;
  c.sampling.rays = 512;
  c.cameras.exposure = false;  // of a rig, and tried before all others
  c.cameras.drift = false;
  c.cameras.clock = false;
  return c;
}

}  // namespace

TEST_SUITE("train/still") {
  TEST_CASE(
      "pixels over time prove what changes, at every moment and in turns, and prove that nothing does") {
    for (const bool turns : {false, true}) {
      CAPTURE(turns);
      const Dataset moving = make_synth("toy", rig(turns)), still = make_synth("static", rig(turns));
      CHECK(still_cameras(train_of(moving)).size() == 5);
      CHECK(verdict_on(train_of(moving)) == StillVerdict::changed);
      CHECK(verdict_on(train_of(still)) == StillVerdict::unchanged);
      CHECK(mean_share(train_of(still)) == 0);
    }
  }

  TEST_CASE("a picture differs where its camera's still picture shows something else, and there alone") {
    const Dataset moving = make_synth("ball", rig()), still = make_synth("static", rig());
    const std::vector<StillCamera> cameras = still_cameras(train_of(moving));
    REQUIRE(cameras.size() == 5);
    const StillCamera& c = cameras.front();
    REQUIRE(c.frames.size() == 10);
    CHECK(c.factor == 1);
    const auto alpha = [&](std::size_t moment, std::size_t i) {
      return train_of(moving).frames[std::size_t(c.frames[moment])].image.pixel(i)[3];
    };
    int wrong = 0, differing = 0;
    for (std::size_t moment = 0; moment < c.frames.size(); ++moment)
      for (std::size_t i = 0; i < c.ever.size(); ++i) {
        int covered = 0;
        for (std::size_t other = 0; other < c.frames.size(); ++other) covered += alpha(other, i) > 0;
        differing += c.now[moment][i];
        wrong += covered == 0 && c.now[moment][i];  // nothing ever passes here
        wrong += c.now[moment][i] && !c.ever[i];
        wrong += covered == 1 && alpha(moment, i) == 65535 && !c.now[moment][i];
      }
    CHECK(differing > 60);
    CHECK(wrong <= 3);  // corners that too few beside differ with
  }

  TEST_CASE("noise, an exposure that flickers and a hand that shakes are no change; what moves still is") {
    SynthOptions opaque = rig();
    opaque.size = 64;
    opaque.look.opaque = true;
    const Dataset moving = make_synth("toy", opaque), still = make_synth("static", opaque);
    struct Row {
      const char* name;
      double noise, flicker, shake;
    };
    for (const Row& r : {Row{"noise", 0.015, 0, 0}, Row{"flicker", 0, 0.05, 0}, Row{"shake", 0, 0, 0.2},
                         Row{"all", 0.01, 0.03, 0.1}}) {
      CAPTURE(std::string(r.name));
      const Split worse_still = worse(train_of(still), r.noise, r.flicker, r.shake);
      CHECK(mean_share(worse_still) < 0.001);
      CHECK(verdict_on(worse_still) != StillVerdict::changed);
      CHECK(verdict_on(worse(train_of(moving), r.noise, r.flicker, r.shake)) == StillVerdict::changed);
    }
  }

  TEST_CASE("one camera that was touched, or one that shows something else, proves nothing for five") {
    const Dataset still = make_synth("static", rig());
    const Split touched = retaken(train_of(still), [&](const Reader& read, int f, int x, int y, int c) {
      const bool moved = f % 5 == 2 && f > 25;  // one of the cameras, from half time on
      return read(x + (moved ? 3 : 0), y, c);
    });
    CHECK(verdict_on(touched) == StillVerdict::unsure);
  }

  TEST_CASE("what a mask ignores is no evidence") {
    const Dataset still = make_synth("static", rig());
    Split painted = retaken(train_of(still), [](const Reader& read, int f, int x, int y, int c) {
      return x > 15 && x < 22 && y > 15 && y < 22 ? f % 7 / 7.0 : read(x, y, c);
    });
    CHECK(verdict_on(painted) == StillVerdict::changed);
    for (Frame& f : painted.frames) {
      f.ignored = PixelMask(f.image.width, f.image.height);
      for (int y = 16; y < 22; ++y)
        for (int x = 16; x < 22; ++x) f.ignored.set(std::size_t(y * f.image.width + x));
    }
    CHECK(mean_share(painted) == 0);
    CHECK(verdict_on(painted) == StillVerdict::unchanged);
    for (const StillCamera& camera : still_cameras(painted)) CHECK(share_of(camera.unknown) > 0);
  }

  TEST_CASE("light that fades in all pictures is not taken for a flicker of the exposure") {
    SynthOptions fading = rig();
    fading.look.fade = 0.5;
    CHECK(verdict_on(train_of(make_synth("static", fading))) != StillVerdict::unchanged);
    fading.look.fade = 0.1;
    CHECK(verdict_on(train_of(make_synth("static", fading))) != StillVerdict::unchanged);
  }

  TEST_CASE("in a dark scene as much is proved as in a bright one") {
    SynthOptions opaque = rig();
    opaque.look.opaque = true;
    for (const char* scene : {"toy", "static"}) {
      CAPTURE(scene);
      const Dataset data = make_synth(scene, opaque);
      Split dark = train_of(data);
      for (Frame& f : dark.frames) {
        Image16 image = f.image.unpacked();
        for (std::size_t i = 0; i < image.rgba.size(); ++i)
          if (i % 4 < 3) image.rgba[i] = std::uint16_t(std::lround(0.02 * image.rgba[i]));
        f.image = image;
      }
      const float unit = brightness({}, picture_stats(dark));
      CHECK(unit < 0.03f);
      const StillProof proof = prove(dark, unit);
      REQUIRE(proof.evidence);
      CHECK(proof.evidence->verdict == verdict_on(train_of(data)));
      const double bright = mean_share(train_of(data));
      CHECK(std::abs(proof.evidence->share - bright) <= 0.3 * bright);
    }
  }

  TEST_CASE("only cameras that are known, stand still and have three moments say anything") {
    const Dataset data = make_synth("ball", rig());
    Split moved = train_of(data), few = moved;
    const Split unnamed = nameless(moved);
    CHECK(still_cameras(unnamed).empty());
    CHECK_FALSE(prove(unnamed).evidence);
    for (Frame& f : moved.frames)
      if (f.camera_id == 1 && f.time > 0.5) f.camera.position.x += 0.1;
    CHECK(still_cameras(moved).size() == 4);
    std::erase_if(few.frames, [](const Frame& f) { return f.time > 0.15; });  // two moments
    CHECK(still_cameras(few).empty());
  }

  TEST_CASE("cells through which something moves may change, and most others may not") {
    const Dataset data = make_synth("toy", {.frames = 10, .size = 64, .rig = {.cameras = 6}});
    const Box box{{-1.1f, -1.1f, -1.1f}, {1.1f, 1.1f, 1.1f}};
    const BitGrid cells = changing_cells(still_cameras(train_of(data)), train_of(data), box);
    REQUIRE(cells.cells() > 0);
    CHECK(cells.count() < cells.cells() / 5);
    const SynthScene scene = SynthScene::open("toy");
    int moving = 0, missed = 0;
    for (int moment = 0; moment < 10; ++moment) {
      const SynthMoment at = scene.at(moment / 9.0);
      for (std::size_t c = 0; c < cells.cells(); ++c) {
        if (at.distance(at.bodies() - 1, cast<double>(cells.center(cells.cell_at(c)))) > 0) continue;
        ++moving;
        missed += !cells.test(c);
      }
    }
    CHECK(moving > 300);
    CHECK(missed == 0);
    // Cameras that take turns miss what moves when it is another's turn: they do not vote.
    const Dataset turns = make_synth("toy", rig(true));
    CHECK(changing_cells(still_cameras(train_of(turns)), train_of(turns), box).cells() == 0);
  }

  TEST_CASE("motion is stored from the first step on only where something may change") {
    const Dataset data = make_synth("toy", {.frames = 6, .size = 48, .rig = {.cameras = 5}});
    Config config = rig_choice();
    config.run.max_steps = 2;
    config.grid.radiance = {16};
    config.grid.radiance_start = {0};
    config.motion.points = 4;
    config.grid.motion = {32};
    config.grid.motion_start = {0};
    const auto bricks = [&](const Config& c, const Split& split) {
      Trainer trainer(c, split, data.time_map);
      while (!trainer.done()) trainer.step();
      return trainer.model().motion.levels.back().topology->bricks.size();
    };
    const std::size_t all = bricks(config, nameless(train_of(data))), some = bricks(config, train_of(data));
    CHECK(some < all);
    config.motion.rest = 0;
    CHECK(bricks(config, train_of(data)) == all);
    // A plume is most of its pictures: no camera is steady before it, and where a difference is sure is not
    // all that changes.
    config.motion.rest = 0.5f;
    const Dataset smoke = make_synth("smoke", {.frames = 8, .size = 48, .rig = {.cameras = 5}});
    REQUIRE(still_cameras(train_of(smoke)).size() == 5);
    CHECK(bricks(config, train_of(smoke)) == bricks(config, nameless(train_of(smoke))));
  }

  TEST_CASE("a share of the rays is drawn where a camera that stands still sees a change") {
    SynthOptions opaque = rig();
    opaque.look.opaque = true;
    const Dataset data = make_synth("ball", opaque);
    const Split& train = train_of(data);
    const std::vector<StillCamera> cameras = still_cameras(train);
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    SamplingConfig config = preset("fast").sampling;
    config.carve = 0;
    std::vector<CoarseMask> moving(train.frames.size());
    for (const StillCamera& camera : cameras)
      for (std::size_t i = 0; i < camera.frames.size(); ++i)
        moving[std::size_t(camera.frames[i])] = camera.changing(i);
    const auto share_near = [&](float changing) {
      config.changing = changing;
      BatchSampler sampler(train, box, config, 1);
      sampler.set_moving(moving, 0);
      double near = 0, all = 0;
      Batch batch;
      for (int step = 0; step < 4; ++step) {
        sampler.draw(step, 1, 0.05f, {}, {}, batch);
        for (std::size_t r = 0; r < batch.rays.size(); ++r) {
          const Frame& frame = train.frames[std::size_t(batch.frames[std::size_t(batch.slot_of(int(r)))])];
          const StillCamera& camera = cameras[std::size_t(frame.camera_id)];
          const auto moment = std::size_t(
              std::find(camera.frames.begin(), camera.frames.end(), &frame - train.frames.data()) -
              camera.frames.begin());
          if (batch.rays[r].count == 0) continue;  // it misses the box, and has no origin
          const Projection p = project(frame.camera, cast<double>(batch.rays[r].origin));
          constexpr int kNear = 6;  // pixels
          bool any = false;
          for (int y = std::max(0, int(p.v) - kNear); y <= std::min(camera.height - 1, int(p.v) + kNear); ++y)
            for (int x = std::max(0, int(p.u) - kNear); x <= std::min(camera.width - 1, int(p.u) + kNear);
                 ++x)
              any = any || camera.now[moment][std::size_t(y) * std::size_t(camera.width) + std::size_t(x)];
          near += any;
          ++all;
        }
      }
      return near / all;
    };
    const double without = share_near(0), some = share_near(0.3f), most = share_near(0.9f);
    CHECK(some > without + 0.05);
    CHECK(most > some + 0.1);
  }

  TEST_CASE("proved change keeps motion where fits are too short to see a gain; none proved needs no fit") {
    const Dataset moving = make_synth("toy", rig(true)), still = make_synth("static", rig(true));
    const EffectChoice a = choose_effects(rig_choice(), train_of(moving), moving.time_map),
                       b = choose_effects(rig_choice(), train_of(still), still.time_map);
    REQUIRE(a.still);
    CHECK(a.still->verdict == StillVerdict::changed);
    CHECK(a.still->cameras == 5);
    CHECK(a.still->changing >= 2);
    CHECK(a.still->share > a.still->threshold);
    CHECK(a.chosen.has(Effect::motion));
    REQUIRE(!a.verdicts.empty());
    CHECK((a.verdicts[0].decision == EffectDecision::proved || a.verdicts[0].decision == EffectDecision::on));
    CHECK(a.verdicts[0].where < 0.5);  // it was compared where pixels change
    REQUIRE(b.still);
    CHECK(b.still->verdict == StillVerdict::unchanged);
    CHECK_FALSE(b.chosen.has(Effect::motion));
    CHECK_FALSE(b.chosen.has(Effect::light));
    CHECK(b.trials.empty());
    CHECK(b.note.find("stands still") != std::string::npos);
  }
}
