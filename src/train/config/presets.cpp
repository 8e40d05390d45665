// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/config.hpp"

namespace splinevox {
namespace {

/// On finer motion lattices fewer pixels act on a vertex. So the priors that hold its curve together must be
/// weaker, and motion that no picture asks for must be pulled to zero (docs/experiments.md).
void set_fine_curves(LossConfig& loss) {
  loss.curve_length = 0.02f;
  loss.curve_rest = 1e-4f;
}

/// What our presets share beyond the defaults: view dependence learns fast, its finer harmonics late (early
/// they explain motion away), and curves of many points are held together by the length of their polygons,
/// which costs static matter nothing, and keep only the knots they need. Light changes slowly. Matter that is
/// not visible is emptied, because motion would carry it into views that no picture was taken from
/// (docs/experiments.md).
Config ours() {
  Config c;
  c.run.surroundings = true;
  c.optimiser.lr_sh = 0.05f;
  c.radiance.sh_order = 2;
  c.radiance.sh_start = {0, .55f};
  c.motion.halve_start = {.3f};
  c.grid.empty_start = {.54f, .7f, .8f};
  c.grid.few_cells = 144;
  c.loss.transmittance = 0.03f;
  c.loss.curve_length = 0.075f;
  c.loss.curve_light = 1e-3f;
  c.loss.curve_presence = 1e-4f;
  c.loss.curve_knots = 3e-4f;
  return c;
}

Config draft() {
  Config c = ours();
  c.preset = "draft";
  c.run.max_time = 15;
  c.effects.steps = 0;  // trial fits would take a fifth of the time
  c.run.surroundings = false;
  c.grid.radiance = {40, 64, 96};
  c.grid.radiance_start = {0, .15f, .5f};
  return c;
}

Config fast() {
  Config c = ours();
  c.grid.radiance = {40, 64, 96, 144, 192, 256};
  c.grid.radiance_start = {0, .12f, .25f, .4f, .6f, .8f};
  c.radiance.steepen = 1;  // in longer runs jumpingjacks loses (docs/experiments.md)
  return c;
}

Config standard() {
  Config c = ours();
  c.preset = "standard";
  c.run.max_time = 295;  // and 5 minutes with saving
  c.run.late_cost = 3.6;
  c.grid.radiance = {40, 64, 96, 128, 192, 256};
  c.grid.radiance_start = {0, .1f, .2f, .3f, .4f, .65f};
  c.grid.motion = {4, 8, 16, 32, 64};
  c.grid.motion_start = {0, .04f, .12f, .25f, .6f};
  c.grid.surroundings = {48, 96, 160};
  c.grid.surroundings_start = {0, .2f, .5f};
  set_fine_curves(c.loss);
  return c;
}

Config high() {
  Config c = ours();
  c.preset = "high";
  c.run.max_time = 1785;  // and 30 minutes with saving
  c.run.late_cost = 3.6;
  c.grid.radiance = {40, 64, 96, 144, 192, 256, 384};
  c.grid.radiance_start = {0, .05f, .1f, .2f, .3f, .45f, .75f};
  c.grid.motion = {4, 8, 16, 32, 64};
  c.grid.motion_start = {0, .015f, .05f, .12f, .4f};
  c.grid.surroundings = {48, 96, 160, 224};
  c.grid.surroundings_start = {0, .1f, .3f, .6f};
  set_fine_curves(c.loss);
  c.sampling.rays = 8192;
  return c;
}

/// The paper's weights in our units. Its photometric loss is a mean over rays and 3 channels, ours a sum; its
/// motion losses are means over the 80 samples of a ray as well, ours sums weighted by visibility; its total
/// variation is a mean over 64^3 voxels and the channels of a group, ours a sum.
constexpr float kPhotometric = 3 * 4096;
constexpr float motion_weight(float theirs) { return theirs * 3 / 80; }
constexpr float tv_weight(float theirs, int channels) {
  return theirs * kPhotometric / (64 * 64 * 64) / float(channels);
}

/// What the published methods share: a Bezier curve, and none of what we added.
Config published() {
  Config c;
  c.run.max_time = 600;
  c.run.late_cost = 1;
  c.effects.steps = 0;
  c.run.background_order = -1;
  c.run.find_ground = false;
  c.motion.basis = BasisKind::bezier;
  c.motion.light = false;
  c.motion.presence = false;
  c.cameras.exposure = false;
  c.cameras.drift = false;
  c.cameras.clock = false;
  c.motion.rest = 0;
  c.optimiser.beta2 = 0.999f;
  c.optimiser.shrink = 0;
  c.loss.tv_final = 1;
  c.loss.tv_places = 0;
  c.loss.depth = 0;
  c.loss.tracks = 0;
  c.radiance.opaque_alpha = 0;
  c.sampling.growth = 1;
  c.sampling.carve = 0;
  c.sampling.changing = 0;
  c.sampling.hard_share = 0;
  c.sampling.frames = 8;
  c.sampling.window = 1;
  c.sampling.clipped = false;
  return c;
}

/// The paper's method to the letter, on our lattices. Its rate belongs to two days of an MLP; the shape (one
/// rate for everything, cosine to a quarter) is kept and the rate is raised to what a few thousand steps of a
/// lattice need.
Config paper() {
  Config c = published();
  c.preset = "paper";
  c.motion.points = 5;
  c.motion.first_point = FirstPoint::free;
  c.motion.rigidity = true;
  c.radiance.sh_order = 2;
  c.optimiser.lr_density = c.optimiser.lr_color = c.optimiser.lr_sh = 0.02f;
  c.optimiser.lr_control = 0.002f;  // of the box's longest edge: larger steps jitter
  c.optimiser.lr_rigidity = 0.02f;
  c.optimiser.final_radiance = c.optimiser.final_motion = 0.25f;  // 2e-4 -> 5e-5
  c.loss.offset = motion_weight(30);
  c.loss.offset_rigidity = 0.3f;
  c.loss.divergence = motion_weight(0.3f);
  c.loss.tv_density = tv_weight(1e-4f, 1);
  c.loss.tv_rigidity = tv_weight(1e-4f, 1);
  c.loss.tv_color = c.loss.tv_sh = tv_weight(1e-4f, 3 + 9);
  c.loss.tv_control = tv_weight(1e-4f, 3 * 5);
  return c;
}

/// What the released code does: one dense-equivalent lattice of 64 cells, black background, one
/// rate 1e-2 -> 5e-5, four control points of which the first is zero. Its spherical harmonics are of order 4;
/// ours end at
/// 3. Its divergence term has no gradient, so here it is 0. Use --downscale 3 on 400-pixel images for its
/// image size.
Config nerf_atlas() {
  Config c = published();
  c.preset = "nerf_atlas";
  c.run.background = {0, 0, 0};
  c.grid.radiance = {64};
  c.grid.radiance_start = {0};
  c.grid.motion = {64};
  c.grid.motion_start = {0};
  c.grid.prune_alpha = 0;
  c.motion.points = 4;
  c.motion.first_point = FirstPoint::zero;
  c.radiance.sh_order = 3;
  c.optimiser.lr_density = c.optimiser.lr_color = c.optimiser.lr_sh = 1e-2f;
  c.optimiser.lr_control = 1e-2f / 2.6f;  // its box is 2.6 wide
  c.optimiser.lr_rigidity = 1e-2f;
  c.optimiser.final_radiance = c.optimiser.final_motion = 5e-3f;
  c.loss.tv_density = tv_weight(1e-3f, 1);
  c.loss.tv_rigidity = tv_weight(1e-4f, 1);
  c.loss.tv_color = c.loss.tv_sh = tv_weight(1e-4f, 3 + 16);
  c.loss.tv_control = tv_weight(1e-4f, 3 * 3);
  c.loss.offset = motion_weight(30);
  c.loss.offset_rigidity = 3e-3f;
  c.loss.divergence = 0;
  c.loss.ramp = true;
  c.sampling.background = BackgroundKind::fixed;
  return c;
}

}  // namespace

// Usual steps are about the median of the preset's runs in bench/results/quality.jsonl. Of draft it has none.
const std::vector<Preset>& presets() {
  static const std::vector<Preset> list = {
      {"draft", "a first look: 15 seconds, up to 96 cells", draft(), 1500},
      {"fast", "the default: 60 seconds, up to 256 cells", fast(), 2800},
      {"standard", "better for longer: 5 minutes, up to 256 cells", standard(), 10800},
      {"high", "the best mean: 30 minutes, up to 384 cells", high(), 29400},
      {"paper", "the paper's method to the letter: Bezier of 5 points, its losses and weights; 10 minutes",
       paper()},
      {"nerf_atlas",
       "the released code's choices: 64 cells, black background, order 3 harmonics (its own: 4); 10 minutes",
       nerf_atlas()},
  };
  return list;
}

}  // namespace splinevox
