// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <vector>

#include "splinevox/data/synth.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/start.hpp"

using namespace splinevox;

namespace {

/// A plume before six cameras that stand still.
const Dataset& plume() {
  static const Dataset data = make_synth("smoke", {.frames = 16, .size = 48, .rig = {.cameras = 6}});
  return data;
}

Config plume_run(const EffectSet& effects) {
  Config c = preset("fast");
  apply(effects, c);
  c.run.max_time = 0;
  c.run.max_steps = 150;
  c.grid.radiance = {20, 32};
  c.grid.radiance_start = {0, 0.4f};
  c.grid.motion = {4, 8, 16};
  c.grid.motion_start = {0, 0.1f, 0.3f};
  c.sampling.rays = 1024;
  c.sampling.growth = 1;
  c.sampling.occupancy_cells = 32;
  c.sampling.occupancy_every = 50;
  return c;
}

/// Mean PSNR of pictures that were not trained on.
double quality_with(const EffectSet& effects) {
  const Dataset& data = plume();
  return test::test_psnr(test::trained(plume_run(effects), data), data);
}

}  // namespace

TEST_SUITE("train/presence") {
  TEST_CASE("a plume is shown better with presence than by all that only moves and lights matter") {
    const EffectSet moves = EffectSet().with(Effect::motion).with(Effect::light);
    const double without = quality_with(moves), with = quality_with(moves.with(Effect::presence));
    CAPTURE(without);
    CAPTURE(with);
    CHECK(with > without + 0.3);
  }

  TEST_CASE("only thin matter that may come and go is trained with less skipped") {
    const PictureStats stats = picture_stats(*plume().find("train"));
    CHECK(stats.thin());
    CHECK_FALSE(picture_stats(*make_synth("ball", {.frames = 4, .size = 32}).find("train")).thin());
    Config c = preset("fast");
    c.motion.presence = true;
    CHECK(for_thin(stats, c).sampling.occupancy_alpha < 0.2f * c.sampling.occupancy_alpha);
    CHECK(for_thin(stats, c).grid.box_alpha < 0.2f * c.grid.box_alpha);
    c.motion.presence = false;
    CHECK(for_thin(stats, c).sampling.occupancy_alpha == c.sampling.occupancy_alpha);
  }

  TEST_CASE("rays are asked to end or to pass where silhouettes are known and matter is solid") {
    const auto weight = [](const Dataset& data) {
      return for_silhouettes(picture_stats(*data.find("train")), preset("fast")).loss.transmittance;
    };
    CHECK(weight(make_synth("ball", {.frames = 4, .size = 32})) > 0);
    CHECK(weight(plume()) == 0);
    CHECK(weight(make_synth("ball", {.frames = 4, .size = 32, .look = {.opaque = true}})) == 0);
  }

  TEST_CASE("presence is left out where nothing is tried, and where a first point is pinned to zero") {
    Config c = preset("fast");
    c.effects.steps = 0;
    CHECK(effects_of(c).has(Effect::presence));
    CHECK_FALSE(choose_effects(c, *plume().find("train"), {}).chosen.has(Effect::presence));
    c.motion.basis = BasisKind::bezier;
    c.motion.first_point = FirstPoint::zero;
    CHECK_FALSE(effects_of(c).has(Effect::presence));
  }
}
