// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "splinevox/data/synth.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"

namespace splinevox::test {

/// A ball that moves along a line, small enough to learn in a second.
inline const Dataset& ball() {
  static const Dataset data = make_synth("ball", {.frames = 24, .size = 40, .seed = 3});
  return data;
}

/// A run of half a second: both lattices refined once.
inline Config short_run(int steps = 100) {
  Config c = small_run(steps);
  c.run.seed = 5;
  c.grid.radiance = {20, 32};
  c.grid.radiance_start = {0, 0.4f};
  c.grid.motion_start = {0.1f, 0.4f};
  c.sampling.frames = 8;
  c.sampling.growth = 2;
  c.sampling.occupancy_every = 40;
  return c;
}

inline bool finite(const Channels& c) {
  for (const float v : c.values)
    if (!std::isfinite(v)) return false;
  return true;
}

/// Trains to the end of the budget: no step may be discarded and nothing may be other than finite.
inline VoxelModel trained(const Config& config, const Split& split, const TimeMap& map = {}) {
  Trainer trainer(config, split, map);
  StepReport last;
  while (!trainer.done()) {
    last = trainer.step();
    REQUIRE_FALSE(last.discarded);
    REQUIRE(std::isfinite(last.loss));
  }
  REQUIRE(last.progress == 1);
  VoxelModel model = trainer.model();
  REQUIRE(finite(model.radiance.raw));
  for (const Channels& level : model.motion.levels) REQUIRE(finite(level));
  return model;
}

/// The plain scene's model: what hard cases begin with or are compared to.
inline const VoxelModel& plain_model() {
  static const VoxelModel model = trained(short_run(), *ball().find("train"));
  return model;
}

/// Mean PSNR over frames that `keep` admits, pictures multiplied by `gain` first.
inline double quality(const VoxelModel& model, const Split& split, float gain = 1,
                      const std::function<bool(double)>& keep = {}) {
  Renderer renderer(model);
  std::vector<double> db;
  for (const Frame& f : split.frames) {
    if (keep && !keep(f.time)) continue;
    Image got = renderer.render(f.camera, f.time).rgb, want = composite(f.image, model.background.color);
    for (float& v : got.data) {
      REQUIRE(std::isfinite(v));
      v *= gain;
    }
    for (float& v : want.data) v *= gain;
    db.push_back(psnr(clamped(got), clamped(want)));
  }
  REQUIRE_FALSE(db.empty());
  return mean_psnr(db);
}

/// The same split with every picture's values passed through `change(r, g, b, a)` in [0, 1].
inline Split repainted(Split split, const std::function<void(double (&)[4])>& change) {
  for (Frame& f : split.frames) {
    Image16 image = f.image.unpacked();
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
      double v[4];
      for (int c = 0; c < 4; ++c) v[c] = image.rgba[i + c] / 65535.0;
      change(v);
      for (int c = 0; c < 4; ++c) image.rgba[i + c] = std::uint16_t(std::lround(v[c] * 65535));
    }
    f.image = image;
  }
  return split;
}

/// The same split seen from cameras moved to scale * position + shift.
inline Split moved(Split split, double scale, Vec3d shift) {
  for (Frame& f : split.frames) f.camera.position = scale * f.camera.position + shift;
  return split;
}

}  // namespace splinevox::test
