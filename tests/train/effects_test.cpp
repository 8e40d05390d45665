// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/effects.hpp"

#include <doctest/doctest.h>

#include "splinevox/data/synth.hpp"
#include "support/on_threads.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"

using namespace splinevox;

namespace {

/// A choice in miniature.
Config short_choice() {
  Config c = preset("fast");
  c.run.max_time = 0;
  c.run.max_steps = 8000;
  c.sampling.rays = 1024;
  return c;
}

EffectChoice choose(const Dataset& data, const Config& config = short_choice()) {
  return choose_effects(config, *data.find("train"), data.time_map);
}

const EffectVerdict* verdict(const EffectChoice& choice, Effect effect) {
  for (const EffectVerdict& v : choice.verdicts)
    if (v.effect == effect) return &v;
  return nullptr;
}

}  // namespace

TEST_SUITE("train/effects") {
  TEST_CASE("a set of effects goes into a configuration and comes back") {
    for (const std::string preset_name : {"fast", "paper", "nerf_atlas"}) {
      Config c = preset(preset_name);
      const EffectSet all = effects_of(c);
      CHECK(all.has(Effect::motion));
      for (const Effect effect : kAllEffects) {
        const EffectSet fewer = all.without(effect);
        CHECK_FALSE(fewer.has(effect));
        apply(fewer, c);
        CHECK(effects_of(c) == fewer);
      }
    }
    const EffectSet moving = EffectSet{}.with(Effect::motion).with(Effect::rigidity).with(Effect::view, 1);
    CHECK_FALSE(moving.without(Effect::motion).has(Effect::rigidity));
    CHECK(to_string(EffectSet{}.with(Effect::light).with(Effect::view, 1).with(Effect::motion)) ==
          "motion, view, light");
    CHECK(to_string(EffectSet{}) == "none");
  }
  TEST_CASE(
      "what does not move needs no motion, what moves needs it, and the choice is the same for any number of "
      "threads") {
    const Dataset still = make_synth("static", {.frames = 40, .size = 40}),
                  moving = make_synth("ball", {.frames = 40, .size = 40});
    const EffectChoice a = choose(still), b = choose(moving);
    CHECK_FALSE(a.chosen.has(Effect::motion));
    CHECK_FALSE(a.chosen.has(Effect::light));
    CHECK(b.chosen.has(Effect::motion));
    CHECK(a.held_out == 8);
    REQUIRE(verdict(b, Effect::motion));
    CHECK(verdict(b, Effect::motion)->decision == EffectDecision::on);
    CHECK(verdict(b, Effect::motion)->gain.lo > 0.1);
    CHECK(verdict(b, Effect::motion)->bytes_ratio > 1);
    REQUIRE(verdict(a, Effect::motion));
    CHECK(verdict(a, Effect::motion)->decision != EffectDecision::on);
    CHECK_FALSE(a.chosen.has(Effect::presence));
    CHECK_FALSE(b.chosen.has(Effect::presence));
    CHECK(b.points == short_choice().motion.points);
    CHECK(a.trials.size() == 4);  // the last with presence
    CHECK(b.trials.size() == 3);

    Config brief = short_choice();
    brief.effects.steps = 20;
    const EffectChoice two = test::on_threads(2, [&] { return choose(moving, brief); }),
                       three = test::on_threads(3, [&] { return choose(moving, brief); });
    REQUIRE(two.trials.size() >= 2);
    REQUIRE(three.trials.size() == two.trials.size());
    CHECK(three.chosen == two.chosen);
    CHECK(three.points == two.points);
    for (std::size_t i = 0; i < two.trials.size(); ++i) CHECK(three.trials[i].psnr == two.trials[i].psnr);
  }
  TEST_CASE("motion is found in a scene of which little moves, where the rest is the better for none") {
    Config config = short_choice();
    config.motion.presence = false;
    config.sampling.rays = 2048;
    const EffectChoice c = choose(make_synth("toy", {.frames = 60, .size = 96}), config);
    CHECK(c.chosen.has(Effect::motion));
    REQUIRE(verdict(c, Effect::motion));
    CAPTURE(verdict(c, Effect::motion)->gain.mean);
    CHECK(verdict(c, Effect::motion)->gain.mean > 0.5);
    CHECK(verdict(c, Effect::motion)->where > 0.005);
    CHECK(verdict(c, Effect::motion)->where <
          0.1);  // of the pictures; the ball's share of what they show is larger
    CHECK(c.trials[0].mean() < c.trials[1].mean());  // on the whole, motion loses so early
  }
  TEST_CASE(
      "time tells where a film is taken from, and nothing of cameras anywhere, few or many, of a rig, or of "
      "one that stands") {
    const auto share_of = [](const Dataset& data) {
      return view_told_by_time(*data.find("train"), {0, 0, 0}, 1.0 / 9);
    };
    for (const int frames : {8, 16, 100}) {
      CAPTURE(frames);
      CHECK(share_of(make_synth("ball", {.frames = frames, .size = 8})) < 0.6);
      CHECK(share_of(make_synth("ball", {.frames = frames, .size = 8, .orbit = 0.5})) >
            (frames < 16 ? 0.7 : 0.9));
    }
    CHECK(share_of(make_synth("ball", {.frames = 100, .size = 8, .orbit = 3})) < 0.8);
    Dataset paused = make_synth("ball", {.frames = 40, .size = 8, .orbit = 0.5});
    for (Frame& f : paused.splits[0].frames) f.time = f.time < 0.5 ? 0.7 * f.time : 0.3 + 0.7 * f.time;
    CHECK(share_of(paused) > 0.9);  // a pause makes it no other film
    Dataset stands = make_synth("ball", {.frames = 20, .size = 8});
    for (Frame& f : stands.splits[0].frames) f.camera = stands.splits[0].frames[0].camera;
    CHECK(share_of(stands) == 0);
    Dataset rig = make_synth("ball", {.frames = 60, .size = 8});
    std::vector<Frame>& frames = rig.splits[0].frames;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].time = double(i / 6) / 9;
      frames[i].camera = frames[i % 6].camera;
    }
    CHECK(share_of(rig) < 0.2);
  }
  TEST_CASE("light that fades is light, not motion") {
    Config config = short_choice();
    config.motion.presence = false;
    const EffectChoice c =
        choose(make_synth("static", {.frames = 60, .size = 48, .look = {.fade = 0.7}}), config);
    CHECK(c.chosen.has(Effect::light));
    CHECK_FALSE(c.chosen.has(Effect::motion));
  }
  TEST_CASE(
      "a long sequence that repeats a motion gets the control points to follow it, one that does it once "
      "keeps few; a model file has grids for them") {
    Config config = short_choice();
    config.motion.presence = false;
    config.sampling.occupancy_cells = 24;
    const EffectChoice often =
        choose(make_synth("ball", {.frames = 1300, .size = 24, .look = {.repeats = 32}}), config);
    CHECK(often.chosen.has(Effect::motion));
    const int pieces_in_the_end = (often.points - 3) << config.motion.halve_start.size();
    CHECK(pieces_in_the_end > 34);
    Config chosen = config;
    apply(often.chosen, chosen);
    chosen.motion.points = often.points;
    CHECK_NOTHROW(validate(chosen));
    CHECK(grids_at_end(chosen) > kMostGrids - 4);  // more would follow it better
    REQUIRE_FALSE(often.points_verdicts.empty());
    CHECK(often.points_verdicts.back().gain.mean > 0.1);
    const EffectChoice once = choose(make_synth("ball", {.frames = 400, .size = 32}));
    CHECK(once.chosen.has(Effect::motion));
    CHECK(once.points < often.points);
  }
  TEST_CASE("views of one time show no motion, and too few views or steps judge nothing") {
    Dataset data = make_synth("ball", {.frames = 40, .size = 24});
    for (Frame& f : data.splits[0].frames) f.time = 0;
    const EffectChoice one_time = choose(data);
    CHECK_FALSE(one_time.chosen.has(Effect::motion));
    CHECK_FALSE(one_time.note.empty());
    Config brief = short_choice();
    brief.run.max_steps = 300;
    CHECK_FALSE(changes(choose(data, brief).chosen));
    CHECK(choose(data, brief).note == one_time.note);

    const Dataset few = make_synth("ball", {.frames = 6, .size = 24});
    const EffectChoice kept = choose(few);
    CHECK(kept.trials.empty());
    CHECK(kept.chosen ==
          learnable_in(effects_of(short_choice()), false, TakenBy::any).without(Effect::presence));

    Config c = short_choice();
    c.run.max_steps = 300;
    const Dataset moving = make_synth("ball", {.frames = 40, .size = 24});
    const EffectChoice short_run = choose(moving, c);
    CHECK(short_run.trials.empty());
    CHECK(short_run.on_trust);
    CHECK(short_run.chosen == learnable_in(effects_of(c), false, TakenBy::any).without(Effect::presence));
    c.run.max_time = 600;  // what ends a run first counts
    CHECK(choose(moving, c).trials.empty());
    c = short_choice();
    c.effects.steps = 0;
    CHECK(choose(moving, c).trials.empty());
  }
  TEST_CASE("where the seconds of a run leave no time for trials, what can stand in for others is left out") {
    const Dataset data = make_synth("ball", {.frames = 40, .size = 24});
    Config c = short_choice();
    c.run.max_steps = 0;
    c.run.max_time = 60;
    c.effects.most_time = 1e-9f;
    const EffectChoice none = choose(data, c);
    CHECK(none.trials.empty());
    CHECK(none.chosen == learnable_in(effects_of(c), false, TakenBy::any).without(Effect::presence));
    CHECK(none.note.find("no time to try motion, light, presence") != std::string::npos);

    const auto by_all = [&](bool by_clock, double used = 0) {
      return choose_effects(c, *data.find("train"), data.time_map, {}, {}, by_clock, used);
    };
    CHECK_FALSE(by_all(false).trials.empty());  // of several processes each has a clock of its own
    c.effects.most_time = 1;
    CHECK(by_all(true, 60).trials.empty());  // the seconds went on loading
    c.effects.most_time = 0;
    CHECK_FALSE(by_all(true).trials.empty());
  }
}
