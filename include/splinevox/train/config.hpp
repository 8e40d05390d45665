// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "splinevox/field/model.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

enum class OptimiserKind { adam, rmsprop };
enum class DivergenceKind { analytic, hutchinson };
/// What training composites rays and targets over: run.background; a colour drawn for every ray; or the first
/// behind opaque pixels, which may show it, and the second behind transparent ones.
enum class BackgroundKind { fixed, random, ground };

/// Length and repeatability of a run.
struct RunConfig {
  double max_time = 60;  ///< seconds training may take; schedules are laid out over it. 0: max_steps decides
  double late_cost = 2.6;  ///< by the clock, how much dearer than the first step the last one is taken to be:
                           ///< schedules run ahead (clock_progress)
  int max_steps = 0;       ///< optimiser steps; 0: max_time decides. Both given: whichever ends first
  double checkpoint_every = 30;  ///< seconds; more where checkpoints would cost over a 50th of the time
  std::uint64_t seed = 1;
  int downscale = 1;                       ///< block size of the area filter on the images
  std::vector<float> background{1, 1, 1};  ///< colour behind the scene, [3] in [0, 1]
  int background_order = 2;   ///< of the colour learned behind opaque pictures, 0..3; -1: run.background
  bool surroundings = false;  ///< whether what stands around the box of opaque pictures is learned
                              ///< (field/model.hpp); needs a learned background
  bool find_ground = true;    ///< whether a plain ground behind opaque pictures is looked for and cut out
};

/// Lattices, coarse to fine over the run.
struct GridConfig {
  std::vector<int> radiance{40, 64, 96, 144};              ///< cells along the box's longest edge, per stage
  std::vector<float> radiance_start{0, .15f, .35f, .55f};  ///< progress in [0, 1) at which each stage begins
  std::vector<int> motion{4, 8, 16, 32};  ///< the same per level of motion, each twice the one before
  std::vector<float> motion_start{0, .08f, .25f, .5f};  ///< progress at which each level is switched on
  std::vector<int> surroundings{48, 96};  ///< cells along an edge of contracted space (math/contract.hpp),
                                          ///< per stage: what few cameras see must be coarse first
  std::vector<float> surroundings_start{0, .4f};  ///< progress at which each stage begins
  float prune_alpha = 1e-3f;                      ///< of one step: bricks below it are dropped at a new stage
  float box_margin = 0.05f;                       ///< added around the visual hull, share of its longest edge
  float box_alpha = 0.1f;  ///< of one step at some time: a new stage's box shrinks to where it is more
  std::vector<float> box;  ///< [6] lo.xyz, hi.xyz in scene units; empty: from silhouettes and cameras
  std::vector<float> empty_start;  ///< progress at which canonical matter is emptied that was not visible
                                   ///< since the start before
  float seen_share = 0.25f;  ///< of the heaviest sample of a ray: samples from this weight on are visible
};

struct RadianceConfig {
  int sh_order = 1;             ///< -1 (none), 0..3
  std::vector<float> sh_start;  ///< progress at which the harmonics of order 1, 2, ... join, the last for all
                                ///< that follow; empty: at the start
  float initial_alpha = 0.01f;  ///< alpha of one step of the first lattice before training
  float opaque_alpha = 0.05f;   ///< the same behind opaque pictures, if it is more
  float outer_alpha = 0.02f;    ///< of each of a ray's samples in the surroundings before training
  float initial_sh = 0;  ///< band 0 at the start: the view factor begins at 1 - sigmoid(Y00 * initial_sh) / 2
};

/// Index of the last start that progress has reached, -1: none.
int reached(const std::vector<float>& starts, double progress);
/// Order of the harmonics that a run has at its progress.
int order_at(const RadianceConfig& config, double progress);

struct MotionConfig {
  bool enabled = true;
  BasisKind basis = BasisKind::bspline;
  int points = 12;  ///< control points K that the basis allows (Basis::trained_points). A sequence of over
                    ///< 240 moments may be given more (train/effects.hpp)
  FirstPoint first_point = FirstPoint::free;
  bool rigidity = true;
  bool light = true;                 ///< a gain per place and time, with or without motion (math/light.hpp)
  bool presence = true;              ///< matter comes and goes, with or without motion (math/presence.hpp)
  float initial_rigidity = 0;        ///< raw: r begins at sigmoid(initial_rigidity)
  std::vector<float> halve_start;    ///< bspline: progress at which every span is halved, K -> 2K - 3, the
                                     ///< curves staying the same
  float rest = 0.5f;                 ///< static regions freeze if at most this share of what is visible moves
                                     ///< (train/bounds/freeze); 0: never
  std::vector<int> elevate_points;   ///< bezier: K after each exact degree elevation
  std::vector<float> elevate_start;  ///< progress at which each happens
};

/// Learning rates are per step; each decays on a cosine from the first value to value * its final share.
struct OptimiserConfig {
  OptimiserKind kind = OptimiserKind::adam;
  float lr_density = 0.25f, lr_color = 0.1f, lr_sh = 0.02f, lr_control = 0.01f, lr_rigidity = 0.01f,
        lr_light = 0.02f, lr_presence = 0.1f, lr_background = 0.02f;
  float final_radiance = 0.1f;  ///< share of lr_density, lr_color, lr_sh, lr_background left at the end
  float final_motion = 0.02f;   ///< share of lr_control, lr_rigidity, lr_light, lr_presence left at the end
  float shrink = 0.3f;  ///< of motion, light, presence that need not be, share of a step (math/shrink.hpp)
  float beta1 = 0.9f, beta2 = 0.99f, epsilon = 1e-8f;
};

/// Weights of the loss terms (Eq. 8 and 9). The photometric term is the sum over rays of the squared RGB
/// error.
struct LossConfig {
  float tv_density = 1e-4f, tv_color = 3e-4f, tv_sh = 0, tv_control = 1e-2f, tv_rigidity = 0,
        tv_light = 1e-4f, tv_presence = 1e-4f;
  float tv_final = 0.003f;   ///< share of these weights that is left at the end; they decay exponentially
  float tv_share = 0.0625f;  ///< share of the bricks visited per step; the weight is divided by it
  float still = 0.03f;  ///< of the squared displacement, in voxels, where a pixel shows nothing that moves
  float along = 0.01f;  ///< of that along the ray, where one shows something that moves
  int tv_places = 96;   ///< places of cameras that stand still, below which tv_density grows in proportion
                        ///< (for_places in train/start.hpp); 0: never
  float depth = 1;      ///< of the relative error of a ray's distance, where a depth map tells it
  float offset = 0;     ///< lambda_off of Eq. 8
  float offset_rigidity = 0.3f;  ///< lambda_r of Eq. 6
  float divergence = 0;          ///< lambda_div of Eq. 8
  DivergenceKind divergence_kind = DivergenceKind::analytic;
  bool ramp = false;  ///< multiply offset and divergence by 1/100 -> 1 over the run, as the released code
  float curve_length = 0;    ///< of the squared lengths between control points, in edges of the box
  float curve_light = 0;     ///< of the squared differences of the raw light between control points
  float curve_presence = 0;  ///< the same of presence
  float curve_knots = 0;     ///< of the jumps at knots that halving brought in, in edges of the box
  float curve_rest = 0;  ///< weight of the lengths of the curves that all levels make together, in edges of
                         ///< the box, all voxels
};

struct SamplingConfig {
  int frames = 16;      ///< training images per step
  float window = 0.3f;  ///< share of the frames, the middle ones in time, that a moving scene begins with
  float window_full = 0.3f;  ///< progress at which the window has grown to all frames
  int rays = 4096;           ///< rays of the first step over all of them, in patches of 2 x 2 pixels
  float growth = 3;          ///< rays of the last step over those of the first, linear in between
  float carve = 0.15f;       ///< share of the rays that look past silhouettes of neighbouring times
  int carve_frames = 4;      ///< how many frames earlier or later such a camera may be
  float carve_speed =
      3;  ///< the fastest that things are taken to move, picture widths per unit of model time
  float changing = 0.3f;     ///< share of the rays, where cameras that stand still see something change
  float step = 0.75f;        ///< march step in voxels of the radiance lattice
  float stop = 1e-3f;        ///< transmittance at which a training ray ends
  float min_weight = 1e-3f;  ///< samples with a smaller share in the pixel get no gradient
  BackgroundKind background = BackgroundKind::random;
  bool clipped = true;            ///< pictures end at 1: where they show 1, more is no error
  int occupancy_cells = 64;       ///< cells along the longest edge of the space-time occupancy
  int occupancy_every = 500;      ///< steps between refreshes
  float occupancy_alpha = 0.01f;  ///< alpha of one step below which a cell is skipped
};

/// Which effects a scene calls for is tried out before training, see train/effects.hpp.
struct EffectsConfig {
  int steps = 200;        ///< of each trial fit; 0: every effect of the configuration is used untried
  float min_gain = 0.1f;  ///< dB on held-out pictures below which an effect is not worth having
  float level = 0.01f;    ///< chance of switching on any effect that gains less, over all comparisons
};

/// What is learned of the cameras of a rig (train/cameras.hpp).
struct CamerasConfig {
  bool exposure = true;         ///< a gain per camera and channel: exposure and white balance
  bool clock = true;            ///< a time offset per camera; needs motion
  float exposure_rate = 0.03f;  ///< share of what is known of the gains that each step replaces
  float most_gain = 4;          ///< and least is one over it
  float most_offset = 2;        ///< intervals between a camera's pictures
  float clock_rate = 0.01f;     ///< step of an offset, intervals; decays as the rates of motion do
};

struct Config {
  std::string preset = "fast";
  RunConfig run;
  GridConfig grid;
  RadianceConfig radiance;
  MotionConfig motion;
  OptimiserConfig optimiser;
  LossConfig loss;
  SamplingConfig sampling;
  CamerasConfig cameras;
  EffectsConfig effects;
};

/// Calls visit(key, member, doc, lo, hi) for every number of a Config: key is "group.name"; lo and hi bound
/// scalars and list elements, inclusive. The one list behind --set, TOML in and out, validation and the help
/// text.
template <class C, class Visit>
void visit_config(C& c, Visit&& visit) {
  constexpr double inf = 1e30;
  visit("run.max_time", c.run.max_time, "seconds of training, 0 = run.max_steps decides", 0, 1e7);
  visit("run.late_cost", c.run.late_cost,
        "by the clock: how much dearer than the first step the last one is taken to be", 1, 100);
  visit("run.max_steps", c.run.max_steps, "optimiser steps, 0 = run.max_time decides", 0, 1e9);
  visit("run.checkpoint_every", c.run.checkpoint_every,
        "seconds between checkpoints, more where each takes long", 0, 1e7);
  visit("run.seed", c.run.seed, "seed of every random draw", 0, 9e15);
  visit("run.downscale", c.run.downscale, "KxK pixel blocks are averaged", 1, 64);
  visit("run.background", c.run.background, "r, g, b behind the scene", 0, 1);
  visit("run.background_order", c.run.background_order,
        "harmonics of a colour learned behind opaque pictures, -1 = run.background", -1, 3);
  visit("run.surroundings", c.run.surroundings,
        "whether what stands around the box of opaque pictures is learned", 0, 1);
  visit("run.find_ground", c.run.find_ground,
        "whether a plain ground behind opaque pictures is looked for and cut out", 0, 1);
  visit("grid.radiance", c.grid.radiance, "cells along the longest edge, per stage", 8, 1024);
  visit("grid.radiance_start", c.grid.radiance_start, "progress at which each stage begins", 0, 1);
  visit("grid.motion", c.grid.motion, "cells along the longest edge, per motion level", 1, 512);
  visit("grid.motion_start", c.grid.motion_start, "progress at which each motion level is switched on", 0, 1);
  visit("grid.surroundings", c.grid.surroundings,
        "cells along an edge of contracted space around the box, per stage", 8, 512);
  visit("grid.surroundings_start", c.grid.surroundings_start, "progress at which each stage begins", 0, 1);
  visit("grid.prune_alpha", c.grid.prune_alpha, "bricks below this alpha per step are dropped", 0, 1);
  visit("grid.box_margin", c.grid.box_margin, "margin around the visual hull, share of its longest edge", 0,
        1);
  visit("grid.box_alpha", c.grid.box_alpha, "alpha per step the box must keep when it shrinks at a new stage",
        0, 1);
  visit("grid.box", c.grid.box, "lo.xyz, hi.xyz of the scene box; empty = automatic", -inf, inf);
  visit("grid.empty_start", c.grid.empty_start, "progress at which matter that is not visible is emptied", 0,
        1);
  visit("grid.seen_share", c.grid.seen_share,
        "weight from which on a sample is visible, share of the heaviest of its ray", 1e-3, 1);
  visit("radiance.sh_order", c.radiance.sh_order, "spherical harmonic order of the view rescale, -1 = none",
        -1, 3);
  visit("radiance.sh_start", c.radiance.sh_start,
        "progress at which the harmonics of order 1, 2, ... join, the last for all that follow", 0, 1);
  visit("radiance.initial_alpha", c.radiance.initial_alpha, "alpha per step before training", 1e-8, 0.5);
  visit("radiance.opaque_alpha", c.radiance.opaque_alpha,
        "alpha per step before training behind opaque pictures, if it is more", 0, 0.5);
  visit("radiance.outer_alpha", c.radiance.outer_alpha,
        "alpha per sample of the surroundings before training", 1e-8, 0.5);
  visit("radiance.initial_sh", c.radiance.initial_sh, "band 0 of the view rescale before training", -20, 20);
  visit("motion.enabled", c.motion.enabled, "whether the scene may move", 0, 1);
  visit("motion.basis", c.motion.basis, trained_basis_names(), 0, 1);
  visit("motion.points", c.motion.points, "control points per curve", kMinPoints, kMaxPoints);
  visit("motion.first_point", c.motion.first_point, "zero (t = 0 is canonical) or free", 0, 1);
  visit("motion.rigidity", c.motion.rigidity, "whether motion is scaled by a learned rigidity", 0, 1);
  visit("motion.light", c.motion.light, "whether the light of a place may change over time", 0, 1);
  visit("motion.presence", c.motion.presence, "whether matter may come and go; not where first_point is zero",
        0, 1);
  visit("motion.initial_rigidity", c.motion.initial_rigidity, "raw rigidity before training", -20, 20);
  visit("motion.halve_start", c.motion.halve_start,
        "bspline: progress at which every span is halved, K -> 2K - 3", 0, 1);
  visit("motion.rest", c.motion.rest,
        "static regions freeze if at most this share of what is visible moves, 0 = never", 0, 1);
  visit("motion.elevate_points", c.motion.elevate_points,
        "bezier: control points after each degree elevation", kMinPoints, kMaxPoints);
  visit("motion.elevate_start", c.motion.elevate_start, "progress at which each elevation happens", 0, 1);
  visit("optimiser.kind", c.optimiser.kind, "adam or rmsprop", 0, 1);
  visit("optimiser.lr_density", c.optimiser.lr_density, "step of raw density", 0, 100);
  visit("optimiser.lr_color", c.optimiser.lr_color, "step of raw colour", 0, 100);
  visit("optimiser.lr_sh", c.optimiser.lr_sh, "step of the view rescale", 0, 100);
  visit("optimiser.lr_control", c.optimiser.lr_control,
        "step of control points, share of the box's longest edge; without rigidity times 2 / cells of the "
        "finest motion level",
        0, 100);
  visit("optimiser.lr_rigidity", c.optimiser.lr_rigidity, "step of raw rigidity", 0, 100);
  visit("optimiser.lr_light", c.optimiser.lr_light, "step of the raw light", 0, 100);
  visit("optimiser.lr_presence", c.optimiser.lr_presence, "step of presence", 0, 100);
  visit("optimiser.lr_background", c.optimiser.lr_background, "step of the harmonics of a learned background",
        0, 100);
  visit("optimiser.final_radiance", c.optimiser.final_radiance, "share of the radiance rates left at the end",
        0, 1);
  visit("optimiser.final_motion", c.optimiser.final_motion, "share of the motion rates left at the end", 0,
        1);
  visit("optimiser.shrink", c.optimiser.shrink,
        "shrinkage of motion and light that is not needed, share of a step", 0, 0.9);
  visit("optimiser.beta1", c.optimiser.beta1, "first moment decay", 0, 0.9999);
  visit("optimiser.beta2", c.optimiser.beta2, "second moment decay", 0, 0.99999);
  visit("optimiser.epsilon", c.optimiser.epsilon, "added to the root of the second moment", 1e-20, 1);
  visit("loss.tv_density", c.loss.tv_density, "total variation of raw density", 0, inf);
  visit("loss.tv_color", c.loss.tv_color, "total variation of raw colour", 0, inf);
  visit("loss.tv_sh", c.loss.tv_sh, "total variation of the view rescale", 0, inf);
  visit("loss.tv_control", c.loss.tv_control, "total variation of control points", 0, inf);
  visit("loss.tv_rigidity", c.loss.tv_rigidity, "total variation of raw rigidity", 0, inf);
  visit("loss.tv_light", c.loss.tv_light, "total variation of the raw light", 0, inf);
  visit("loss.tv_presence", c.loss.tv_presence, "total variation of presence", 0, inf);
  visit("loss.tv_final", c.loss.tv_final, "share of the total variation weights left at the end", 1e-9, 1);
  visit("loss.tv_share", c.loss.tv_share, "share of the bricks visited per step", 1e-4, 1);
  visit("loss.tv_places", c.loss.tv_places,
        "places of cameras that stand still below which tv_density grows in proportion, 0 = never", 0, 1000);
  visit("loss.still", c.loss.still,
        "squared displacement, in voxels, where a picture is known to show nothing that moves", 0, inf);
  visit(
      "loss.along", c.loss.along,
      "squared displacement along the ray, in voxels, where a picture is known to show something that moves",
      0, inf);
  visit("loss.depth", c.loss.depth, "relative error of a ray's distance, where a depth map tells it", 0, inf);
  visit("loss.offset", c.loss.offset, "offset loss (Eq. 6)", 0, inf);
  visit("loss.offset_rigidity", c.loss.offset_rigidity, "lambda_r inside the offset loss", 0, inf);
  visit("loss.divergence", c.loss.divergence, "divergence loss (Eq. 7)", 0, inf);
  visit("loss.divergence_kind", c.loss.divergence_kind, "analytic or hutchinson", 0, 1);
  visit("loss.ramp", c.loss.ramp, "ramp offset and divergence from 1/100 to 1", 0, 1);
  visit("loss.curve_length", c.loss.curve_length, "squared lengths between control points", 0, inf);
  visit("loss.curve_light", c.loss.curve_light, "squared differences of the raw light between control points",
        0, inf);
  visit("loss.curve_presence", c.loss.curve_presence,
        "squared differences of presence between control points", 0, inf);
  visit("loss.curve_knots", c.loss.curve_knots,
        "bspline: jumps of the third derivative at knots that halving brought in", 0, inf);
  visit("loss.curve_rest", c.loss.curve_rest,
        "lengths of the curves as wholes, all levels together: keeps static what need not move", 0, inf);
  visit("sampling.frames", c.sampling.frames, "training images per step", 1, 64);
  visit("sampling.window", c.sampling.window,
        "share of the frames, the middle ones in time, that motion begins with", 0, 1);
  visit("sampling.window_full", c.sampling.window_full, "progress at which the window holds all frames", 0,
        1);
  visit("sampling.rays", c.sampling.rays, "rays of the first step", 64, 1 << 20);
  visit("sampling.growth", c.sampling.growth, "rays of the last step over those of the first", 1, 64);
  visit("sampling.carve", c.sampling.carve,
        "share of the rays that look past the silhouettes of neighbouring times", 0, 0.9);
  visit("sampling.carve_frames", c.sampling.carve_frames, "how many frames away such a camera may be", 1, 64);
  visit("sampling.carve_speed", c.sampling.carve_speed,
        "fastest motion reckoned with, picture widths per unit of time", 0, 1000);
  visit("sampling.changing", c.sampling.changing,
        "share of the rays where cameras that stand still see something change", 0, 0.9);
  visit("sampling.step", c.sampling.step, "march step in voxels", 0.05, 4);
  visit("sampling.stop", c.sampling.stop, "transmittance at which a ray ends", 0, 0.5);
  visit("sampling.min_weight", c.sampling.min_weight,
        "samples with a smaller share in the pixel get no gradient", 0, 0.1);
  visit("sampling.background", c.sampling.background,
        "fixed, random, or ground (fixed behind opaque pixels, random behind transparent ones)", 0, 1);
  visit("sampling.clipped", c.sampling.clipped, "what pictures show as 1 is 1 or more", 0, 1);
  visit("sampling.occupancy_cells", c.sampling.occupancy_cells, "cells of the space-time occupancy", 8, 256);
  visit("sampling.occupancy_every", c.sampling.occupancy_every, "steps between occupancy refreshes", 1, 1e6);
  visit("sampling.occupancy_alpha", c.sampling.occupancy_alpha,
        "alpha per step below which a cell is skipped", 0, 1);
  visit("cameras.exposure", c.cameras.exposure,
        "whether each camera of a rig has an exposure and a white balance of its own", 0, 1);
  visit("cameras.clock", c.cameras.clock, "whether each camera of a rig has a clock of its own", 0, 1);
  visit("cameras.exposure_rate", c.cameras.exposure_rate,
        "share of what is known of the gains that each step replaces", 1e-4, 1);
  visit("cameras.most_gain", c.cameras.most_gain, "largest gain of a camera; the least is one over it", 1,
        1000);
  visit("cameras.most_offset", c.cameras.most_offset,
        "largest offset of a camera's clock, intervals between its pictures", 0, 100);
  visit("cameras.clock_rate", c.cameras.clock_rate, "step of a clock, intervals between its pictures", 0, 1);
  visit("effects.steps", c.effects.steps, "steps of each trial fit, 0 = none is tried", 0, 1e6);
  visit("effects.min_gain", c.effects.min_gain, "dB on held-out pictures that an effect must gain", 0, 100);
  visit("effects.level", c.effects.level, "chance of a wrong switch-on, over all comparisons", 1e-6, 0.4);
}

/// Names of an enum's values in order; the text form in TOML and --set. Specialised per enum.
template <class E>
struct EnumNames;
template <>
struct EnumNames<FirstPoint> {
  static constexpr const char* names[] = {"zero", "free"};
};
template <>
struct EnumNames<OptimiserKind> {
  static constexpr const char* names[] = {"adam", "rmsprop"};
};
template <>
struct EnumNames<DivergenceKind> {
  static constexpr const char* names[] = {"analytic", "hutchinson"};
};
template <>
struct EnumNames<BackgroundKind> {
  static constexpr const char* names[] = {"fixed", "random", "ground"};
};

template <class E>
struct Choice {
  E value;
  const char* name;
};
/// What a configuration may say for an enum, in order. Of the bases those that can be trained.
template <class E>
std::vector<Choice<E>> choices() {
  std::vector<Choice<E>> out;
  if constexpr (std::is_same_v<E, BasisKind>) {
    for (const Basis& b : all_bases())
      if (b.trained) out.push_back({b.kind, b.name});
  } else {
    for (const char* name : EnumNames<E>::names) out.push_back({E(out.size()), name});
  }
  return out;
}
template <class E>
const char* choice_name(E value) {
  if constexpr (std::is_same_v<E, BasisKind>)
    return basis_of(value).name;
  else
    return EnumNames<E>::names[int(value)];
}

struct Preset {
  const char* name;
  const char* summary;  ///< what it is for and what it costs, one line of `train --help`
  Config config;
  int usual_steps = 0;  ///< of its budget: 100 to 200 pictures of 400x400, two cores; 0: not measured
};
/// draft, fast, standard, high, paper, nerf_atlas.
const std::vector<Preset>& presets();
/// Throws Error naming the nearest known preset.
Config preset(const std::string& name);

/// Sets one number from text: `--set group.key=value`. Lists are comma separated. Throws Error naming the
/// key, its range, what was given, and for an unknown key the nearest known one.
void set_config(Config& config, const std::string& assignment, const std::string& where);
/// Applies a TOML file over `config`. Same errors, with file and line.
void read_config(Config& config, const std::string& path);
/// TOML text with every number and its doc line; read_config of it gives the same Config.
std::string write_config(const Config& config);
/// Checks what ranges alone cannot: list lengths, orders, combinations. Throws Error naming the key.
void validate(const Config& config);
/// Control points of a curve of the finished model: training may add to those it begins with.
int points_at_end(const MotionConfig& motion);

}  // namespace splinevox
