// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/prepare.hpp"

#include <doctest/doctest.h>

#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/effects/effect_table.hpp"

using namespace splinevox;

namespace {

const Box kBallBox{{-1.25f, -1.5f, -0.5f}, {1.5f, 1.25f, 2}};
const std::vector<float> kBallBoxNumbers{-1.25f, -1.5f, -0.5f, 1.5f, 1.25f, 2};

/// The moving ball before a grey wall, in a data set that says where the ball is.
Dataset boxed(bool opaque = true) {
  Dataset data = make_synth("ball", {.frames = 40, .size = 32, .look = {.opaque = opaque}});
  data.box = kBallBox;
  return data;
}

Config boxed_run() {
  Config c = preset("fast");
  c.run.max_time = 0;
  c.run.max_steps = 800;
  c.sampling.rays = 512;
  c.effects.steps = 60;
  c.run.surroundings = false;
  c.motion.presence = false;
  c.run.find_ground = false;  // the wall is plain: tests/train/ground_test.cpp
  return c;
}

Prepared kept(const Config& config, Dataset data) {
  return prepare(config, data, {.effects = EffectPolicy::keep});
}

}  // namespace

TEST_SUITE("train/prepare") {
  TEST_CASE("the box of opaque pictures is the data's own, and a trainer trains in it") {
    Dataset data = boxed();
    const Config config = boxed_run();
    const Prepared ready = kept(config, data);
    CHECK(ready.config.grid.box == kBallBoxNumbers);
    REQUIRE(ready.notes.size() == 1);
    CHECK(ready.notes[0] ==
          "opaque pictures: the box is the data's own, 2.75 x 2.75 x 2.5 (--set grid.box=... for another)");
    Trainer trainer(ready.config, *data.find("train"), data.time_map);
    trainer.step();
    CHECK(trainer.model().box == kBallBox);

    // Nothing else was changed, and a second time nothing is.
    Config expected = config;
    expected.grid.box = kBallBoxNumbers;
    CHECK(write_config(ready.config) == write_config(expected));
    const Prepared again = kept(ready.config, data);
    CHECK(write_config(again.config) == write_config(ready.config));
    CHECK(again.notes.empty());
  }
  TEST_CASE("a box that is configured stays; silhouettes need none; without one there is none") {
    Config own = boxed_run();
    own.grid.box = {-2, -2, -2, 2, 2, 2};
    CHECK(kept(own, boxed()).config.grid.box == own.grid.box);
    CHECK(kept(boxed_run(), boxed(false)).config.grid.box.empty());
    Dataset nowhere = boxed();
    nowhere.box.reset();
    CHECK(kept(boxed_run(), nowhere).config.grid.box.empty());
  }
  TEST_CASE("effects are chosen in the data's box, measured and left, or kept untried") {
    Dataset data = boxed();
    Config config = boxed_run();
    config.effects.min_gain = 90;  // nothing gains so much: what is chosen is not what is configured
    int trials = 0;
    std::vector<std::string> notes;
    PrepareOptions options;
    options.on_trial = [&](const EffectTrial&) { ++trials; };
    options.on_note = [&](const std::string& text) { notes.push_back(text); };
    const Prepared chosen = prepare(config, data, options);
    CHECK_FALSE(chosen.config.motion.enabled);
    CHECK_FALSE(chosen.used.has(Effect::motion));
    CHECK(chosen.used == effects_of(chosen.config));
    CHECK(std::size_t(trials) == chosen.effects.trials.size());
    REQUIRE(notes.size() == 2);
    CHECK(notes[0] == chosen.notes.at(0));
    CHECK(notes[1] == "trying out which effects the scene calls for");

    Config in_box = config;
    in_box.grid.box = kBallBoxNumbers;
    const EffectChoice same = choose_effects(in_box, *data.find("train"), data.time_map);
    REQUIRE(same.trials.size() == chosen.effects.trials.size());
    for (std::size_t i = 0; i < same.trials.size(); ++i)
      CHECK(same.trials[i].psnr == chosen.effects.trials[i].psnr);

    const Prepared measured = prepare(config, data, {.effects = EffectPolicy::measure});
    CHECK(write_config(measured.config) == write_config(in_box));
    CHECK(measured.effects.trials.size() == same.trials.size());
    CHECK(measured.effects.chosen == chosen.effects.chosen);
    CHECK(measured.used == learnable_in(effects_of(config), true, TakenBy::any));

    const Prepared untried = kept(config, data);
    CHECK(write_config(untried.config) == write_config(in_box));
    CHECK(untried.effects.trials.empty());
    CHECK(untried.effects.chosen == effects_of(config));
    CHECK(untried.effects.points == config.motion.points);
  }
  TEST_CASE("nothing is behind pictures with alpha, whatever the configuration has") {
    const Config config = boxed_run();
    REQUIRE(config.run.background_order >= 0);
    CHECK(kept(config, boxed()).used.order(Effect::background) == config.run.background_order);
    CHECK(kept(config, boxed(false)).used.order(Effect::background) == EffectSet::kOff);
  }
  TEST_CASE("dark pictures are trained in a unit of their own, which is noted") {
    const Dataset data = make_synth("ball", {.frames = 8, .size = 40, .look = {.light = 0.01}});
    const Prepared ready = kept(boxed_run(), data);
    CHECK(ready.brightness < 0.1f);
    REQUIRE(ready.notes.size() == 1);
    CHECK(ready.notes[0].find("dark pictures") == 0);
    CHECK(kept(boxed_run(), boxed()).brightness == 1);
  }

  TEST_CASE("thin matter that comes and goes learns its density slowly, once however often it is prepared") {
    const Dataset smoke = make_synth("smoke", {.frames = 6, .size = 32, .rig = {.cameras = 4}});
    Config c = boxed_run();
    c.motion.presence = false;
    CHECK(kept(c, smoke).config.optimiser.lr_density == c.optimiser.lr_density);
    c.motion.presence = true;
    const Config slow = kept(c, smoke).config;
    CHECK(slow.optimiser.lr_density < 0.5f * c.optimiser.lr_density);
    CHECK(kept(slow, smoke).config.optimiser.lr_density == slow.optimiser.lr_density);
    CHECK(kept(c, boxed(false)).config.optimiser.lr_density == c.optimiser.lr_density);
  }

  TEST_CASE("without training pictures there is nothing to prepare for") {
    Dataset data = boxed();
    data.splits.erase(data.splits.begin());
    CHECK_THROWS_AS(kept(boxed_run(), data), Error);
  }
}
