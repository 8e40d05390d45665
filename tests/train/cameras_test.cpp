// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <random>

#include "math/exposure.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/rig_dataset.hpp"
#include "support/state_parts.hpp"
#include "train/learn_cameras.hpp"

using namespace splinevox;

namespace {

const std::vector<test::CameraTruth> kCameras = {{{1.1f, 1.0f, 0.9f}}, {{0.9f, 1.1f, 1.0f}},
                                                 {{1.0f, 0.9f, 1.1f}}, {{1.1f, 1.1f, 0.9f}},
                                                 {{0.9f, 0.9f, 1.1f}}, {{1, 1, 1}}};

/// A split without pictures: so many moments of each camera.
Split frames_of(const std::vector<int>& moments) {
  Split out{"train", {}};
  for (int c = 0; c < int(moments.size()); ++c)
    for (int m = 0; m < moments[std::size_t(c)]; ++m)
      out.frames.push_back({.name = "f", .camera = {}, .time = m / 10.0, .image = {}, .camera_id = c});
  return out;
}

/// A split without pictures of one camera that goes its way.
Split on_its_way(int pictures, double step = 0.1) {
  Split out{"train", {}};
  for (int i = 0; i < pictures; ++i) {
    out.frames.push_back({.name = "f", .camera = {}, .time = i / (pictures - 1.0), .image = {}});
    out.frames.back().camera.position = {step * i, 0, 0};
  }
  return out;
}

/// What a learner makes of a few rays of every frame whose model is right in all but the gains.
CameraFits learned_from(const Split& split, const std::function<Vec3(const Frame&)>& gain, int steps,
                        const CamerasConfig& config) {
  CameraFits fits = cameras_to_learn(config, split);
  CameraLearner learner(config, fits, 1);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int step = 0; step < steps; ++step) {
    Batch batch;
    StepSums sums;
    for (const Frame& frame : split.frames)
      for (int i = 0; i < 12; ++i) {
        const Vec3 scene{uniform(random), uniform(random), uniform(random)};
        Vec3 shown, target;
        for (int a = 0; a < 3; ++a) {
          shown[a] = std::min(1.0f, gain(frame)[a] * scene[a]);
          target[a] = neutral_target(shown[a], shown[a], fits.gain_of(frame)[a]);
        }
        batch.shown.push_back({shown, fits.index_of(frame), frame.time});
        batch.targets.push_back(target);
        sums.errors.push_back(photometric_error(scene, target));
      }
    learner.update(fits, split, batch, sums, {}, 1, 1);
  }
  return fits;
}
CameraFits learned_from(const std::vector<Vec3>& gains, int steps, CamerasConfig config = {}) {
  config.drift = false;
  return learned_from(
      frames_of(std::vector<int>(gains.size(), 4)),
      [&](const Frame& f) { return gains[std::size_t(f.camera_id)]; }, steps, config);
}

/// What is chosen for pictures of the built-in scene in which nothing moves.
EffectChoice chosen_of(const SynthOptions& options) {
  Config config = preset("fast");
  config.run.max_time = 0;
  config.run.max_steps = 8000;
  config.sampling.rays = 1024;
  const Dataset data = make_synth("static", options);
  return choose_effects(config, *data.find("train"), data.time_map);
}

}  // namespace

TEST_SUITE("train/cameras") {
  TEST_CASE("a neutral target is what a camera shows without its gain; where it is cut off, a bound") {
    CHECK(neutral_target(0.5f, 0.5f, 1.0f) == 0.5f);
    CHECK(neutral_target(0.5, 0.5, 0.8) == doctest::Approx(0.625));
    CHECK(neutral_target(0.9, 0.9, 0.75) == doctest::Approx(1.2));  // no bound, though beyond 1
    CHECK(neutral_target(1.0f, 1.0f, 0.8f) == at_least(1.25f));
    CHECK(neutral_target(1.0f, 1.0f, 2.0f) == at_least(0.5f));
    CHECK(neutral_target(1.0f, 1.0f, 2.0f, false) == 0.5f);
    CHECK(neutral_target(0.7, 0.3, 0.5) == doctest::Approx(0.4 + 0.6));  // the background has no gain
    const GainTerm<double> term = gain_term(0.6, 0.1, 1.2, false);  // shown 0.6 of a neutral 0.5, model 0.6
    CHECK(term.along / term.square == doctest::Approx(1.0));
    CHECK(gain_term(1.0, 0.0, 1.2, true).square == 0);
  }
  TEST_CASE("a rig is two cameras or more with three moments each; others say nothing") {
    CHECK(rig_of(frames_of({4})).cameras.empty());
    CHECK(rig_of(frames_of({4, 2, 2})).cameras.empty());
    const CameraFits rig = rig_of(frames_of({4, 1, 5}));
    REQUIRE(rig.cameras.size() == 3);
    CHECK(rig.knows(0));
    CHECK_FALSE(rig.knows(1));
    CHECK_FALSE(rig.knows(-1));
    CHECK_FALSE(rig.knows(3));
    CHECK(rig.cameras[2].interval == doctest::Approx(0.1));
    Frame frame{.name = "f", .camera = {}, .time = 0.97, .image = {}, .camera_id = 2};
    CameraFits fits = rig;
    fits.cameras[2].offset = 0.05;
    CHECK(fits.time_of(frame) == 1);  // curves end there
    frame.camera_id = 1;
    fits.cameras[1].gains = {{2, 2, 2}};
    CHECK(fits.gain_of(frame) == Vec3{1, 1, 1});
  }
  TEST_CASE("gains are found but for a common factor, whatever is cut off, and their mean is 1") {
    const std::vector<Vec3> gains = {{1.3f, 1, 0.8f}, {1.1f, 0.9f, 1}, {0.7f, 1.2f, 0.9f}, {1, 1, 1.4f}};
    const CameraFits fits = learned_from(gains, 400);
    for (int a = 0; a < 3; ++a) {
      double mean = 0, got = 0;
      for (std::size_t c = 0; c < gains.size(); ++c) {
        mean += std::log(double(gains[c][a])) / double(gains.size());
        got += std::log(double(fits.cameras[c].gains[0][a]));
      }
      CHECK(std::abs(got) < 1e-5);
      for (std::size_t c = 0; c < gains.size(); ++c)
        CHECK(fits.cameras[c].gains[0][a] == doctest::Approx(gains[c][a] / std::exp(mean)).epsilon(0.005));
    }
  }
  TEST_CASE("a film is one camera on its way, and no pictures from anywhere, nor a few") {
    CHECK(in_sequence(on_its_way(20)));
    CHECK_FALSE(in_sequence(on_its_way(8)));
    CHECK_FALSE(in_sequence(on_its_way(20, 0)));  // it does not move
    CHECK_FALSE(in_sequence(*make_synth("ball", {.frames = 30, .size = 8}).find("train")));
    CHECK(in_sequence(*make_synth("ball", {.frames = 30, .size = 8, .orbit = 0.7}).find("train")));
    CHECK(taken_by(on_its_way(20)) == TakenBy::film);
    CHECK(taken_by(frames_of({4, 4})) == TakenBy::rig);
    CHECK(taken_by(frames_of({4})) == TakenBy::any);
    CHECK(cameras_to_learn({.drift = false}, on_its_way(20)).cameras.empty());
    CHECK(cameras_to_learn({}, on_its_way(20)).cameras.size() == 1);
  }
  TEST_CASE("exposures that drift in a film are found but for a common factor, straight between times") {
    const Split film = on_its_way(40);
    const auto truth = [](const Frame& f) {
      const double wave = 0.3 * std::sin(2 * M_PI * f.time);
      return Vec3{float(std::exp(wave)), float(std::exp(0.5 * wave)), 1};
    };
    const CameraFits fits = learned_from(film, truth, 400, {});
    REQUIRE(fits.cameras.size() == 1);
    CHECK(fits.cameras[0].gains.size() == 7);
    for (const Frame& f : film.frames)
      for (int a = 0; a < 3; ++a) {
        CAPTURE(f.time);
        CHECK(fits.gain_of(f)[a] == doctest::Approx(truth(f)[a]).epsilon(0.06));
      }
    double sum = 0;
    for (const Vec3& gain : fits.cameras[0].gains) sum += std::log(double(gain.x));
    CHECK(std::abs(sum) < 1e-5);
    Frame other = film.frames[0];
    other.time = 1;
    CHECK(fits.gain_of(other) == fits.cameras[0].gains.back());
  }
  TEST_CASE("what all cameras of a rig see get brighter is the scene's, and no drift") {
    const Split rig = frames_of({11, 11, 11});
    const CameraFits fits = learned_from(rig,
                                         [](const Frame& f) {
                                           const float scene = float(1 + 0.3 * f.time),
                                                       own = f.camera_id == 1 ? float(1 + 0.4 * f.time) : 1;
                                           return scene * own * Vec3{1, 1, 1};
                                         },
                                         400, {});
    for (std::size_t k = 0; k < 2; ++k) {
      double sum = 0;
      for (const CameraFit& c : fits.cameras) sum += std::log(double(c.gains[k].x));
      CHECK(std::abs(sum) < 1e-5);
    }
    CHECK(fits.cameras[0].gains[1].x == doctest::Approx(std::pow(1.4, -1 / 3.0)).epsilon(0.05));
    CHECK(fits.cameras[1].gains[1].x == doctest::Approx(std::pow(1.4, 2 / 3.0)).epsilon(0.05));
  }
  TEST_CASE("a black camera keeps to its range and takes no other one with it") {
    const CameraFits fits = learned_from({{1.2f, 1, 1}, {0, 0, 0}, {1 / 1.2f, 1, 1}}, 600, {.most_gain = 3});
    CHECK(fits.cameras[1].gains[0].x == doctest::Approx(1 / 3.0));
    CHECK(fits.cameras[0].gains[0].x == doctest::Approx(1.2).epsilon(0.01));
    CHECK(fits.cameras[2].gains[0].y == doctest::Approx(1).epsilon(0.01));
  }
  TEST_CASE("clocks keep their median at 0 and to their range; frames beyond the ends of time say nothing") {
    const Split split = frames_of({11, 11, 11});
    CameraFits fits = rig_of(split);
    CameraLearner learner({}, fits, 1);
    Batch batch;
    StepSums sums;
    for (const int f : {3, 14, 25}) batch.frames.push_back(f);
    sums.slopes = {0, -1, 0};
    const MomentFactors factors = moment_factors(0.9, 0.99, 1e-8, 100);
    for (int i = 0; i < 1000; ++i) learner.update(fits, split, batch, sums, factors, 1, 1);
    CHECK(fits.cameras[0].offset == 0);
    CHECK(fits.cameras[2].offset == 0);
    CHECK(fits.cameras[1].offset == doctest::Approx(0.2));  // two intervals
    CHECK(learner.strayed(fits));
    learner.look(fits);
    CHECK_FALSE(learner.strayed(fits));
    batch.frames = {3, 21, 25};  // the last frame of the late camera
    sums.slopes = {0, 1, 0};
    const double before = fits.cameras[1].offset;
    learner.update(fits, split, batch, sums, factors, 1, 1);
    CHECK(fits.cameras[1].offset == before);
  }
  TEST_CASE("a run learns the gains of its cameras, and goes on from a checkpoint in the same bits") {
    const Dataset data = test::make_rig("dancer", kCameras, 5, 32);
    Config config = preset("draft");
    config.run.max_time = 0;
    config.run.max_steps = 150;
    config.sampling.rays = 1024;
    config.grid.radiance = {24, 32};
    config.sampling.occupancy_cells = 32;
    config.grid.radiance_start = {0, 0.3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0, 0.2f};
    config.cameras.clock = false;
    const Split& train = *data.find("train");
    Trainer whole(config, train, data.time_map), first(config, train, data.time_map),
        second(config, train, data.time_map);
    while (!whole.done()) whole.step();
    for (int i = 0; i < 70; ++i) first.step();
    second.restore(first.save());
    while (!second.done()) second.step();
    CHECK(test::same_parameters(whole.save(), second.save()));
    REQUIRE(whole.cameras().cameras.size() == kCameras.size());
    for (std::size_t c = 0; c < kCameras.size(); ++c)
      for (int a = 0; a < 3; ++a) {
        CAPTURE(c);
        CHECK(whole.cameras().cameras[c].gains[0][a] == doctest::Approx(kCameras[c].gain[a]).epsilon(0.03));
      }
  }
  TEST_CASE("a run learns how late a camera is") {
    std::vector<test::CameraTruth> cameras(6);
    cameras[2].offset = 0.5 / 8;
    const Dataset data = test::make_rig("ball", cameras, 9, 40);
    Config config = preset("draft");
    config.run.max_time = 0;
    config.run.max_steps = 300;
    config.sampling.rays = 1024;
    config.grid.radiance = {24, 40};
    config.sampling.occupancy_cells = 32;
    config.grid.radiance_start = {0, 0.3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0, 0.2f};
    config.cameras.exposure = false;
    Trainer trainer(config, *data.find("train"), data.time_map);
    while (!trainer.done()) trainer.step();
    const std::vector<CameraFit>& fits = trainer.cameras().cameras;
    REQUIRE(fits.size() == cameras.size());
    for (std::size_t c = 0; c < fits.size(); ++c) {
      CAPTURE(c);
      CHECK(fits[c].interval == doctest::Approx(0.125));
      CHECK(std::abs((fits[c].offset - cameras[c].offset) / fits[c].interval) < (c == 2 ? 0.1 : 0.15));
    }
  }
  TEST_CASE("drift is tried out in a film: found where exposures drift, left out where they do not") {
    const auto choose = [](double drift) {
      return chosen_of({.frames = 36, .size = 48, .orbit = 0.7, .film = true, .drift = drift});
    };
    const EffectChoice drifts = choose(0.3), steady = choose(0);
    CHECK(drifts.chosen.has(Effect::drift));
    CHECK_FALSE(steady.chosen.has(Effect::drift));
    REQUIRE_FALSE(drifts.verdicts.empty());
    CHECK(drifts.verdicts[0].effect == Effect::drift);
    CHECK(*drifts.verdicts[0].spread > 2 * *steady.verdicts[0].spread);
  }
  TEST_CASE("exposures are tried out: found where cameras differ, left out where they agree") {
    const auto choose = [](double exposures) {
      return chosen_of({.frames = 8, .size = 48, .rig = {.cameras = 10, .exposures = exposures}});
    };
    const EffectChoice differ = choose(0.15), agree = choose(0);
    CHECK(differ.chosen.has(Effect::exposure));
    CHECK_FALSE(agree.chosen.has(Effect::exposure));
    CHECK_FALSE(agree.chosen.has(Effect::clock));
    REQUIRE_FALSE(differ.verdicts.empty());
    CHECK(differ.verdicts[0].effect == Effect::exposure);
    CAPTURE(*agree.verdicts[0].spread);
    CHECK(*differ.verdicts[0].spread > 2 * *agree.verdicts[0].spread);
  }
}
