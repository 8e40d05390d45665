// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>
#include <vector>

#include "splinevox/train/config.hpp"

namespace splinevox {

/// Calls visit(key, member, doc, lo, hi) for every number of a Config: key is "group.name"; lo and hi bound
/// scalars and list elements, inclusive. The one list behind --set, TOML in and out, validation and the help
/// text.
template <class C, class Visit>
void visit_config(C& c, Visit&& visit) {
  constexpr double inf = 1e30;
  visit("run.max_time", c.run.max_time, "seconds of training, 0 = run.max_steps decides", 0, 1e7);
  visit("run.late_cost", c.run.late_cost,
        "by the clock: how much dearer than the first step the last one is taken to be", 1, 100);
  visit("run.paced", c.run.paced,
        "by the clock: smaller batches, and no finest lattices, where there is time for few steps", 0, 1);
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
  visit("grid.few_cells", c.grid.few_cells,
        "the most of these cells where cameras stand still at fewer places than loss.tv_places, 0 = as "
        "everywhere",
        0, 1024);
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
  visit("radiance.steepen", c.radiance.steepen,
        "power of a lattice's fineness by which its density is steeper than the first's; not with presence",
        0, 1);
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
  visit("loss.depth", c.loss.depth, "relative error of a ray's distance, where a depth map tells it", 0, inf);
  visit("loss.tracks", c.loss.tracks,
        "how far apart rays of two moments see a tracked point, in hundredths of the box's edge", 0, inf);
  visit("loss.transmittance", c.loss.transmittance,
        "T (1 - T) of what a ray leaves of the light: it ends on something or passes; 0 of opaque pictures "
        "and of thin matter",
        0, inf);
  visit("loss.transmittance_start", c.loss.transmittance_start, "progress at which that begins", 0, 1);
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
  visit("sampling.hard_share", c.sampling.hard_share,
        "share of a picture's rays that are drawn by where it is fitted worst, 0 = evenly", 0, 0.95);
  visit("sampling.hard_start", c.sampling.hard_start, "progress at which that begins", 0, 1);
  visit("sampling.hard_undo", c.sampling.hard_undo,
        "how far weights of the loss undo that: 0 not, 1 all of it", 0, 1);
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
  visit("cameras.drift", c.cameras.drift,
        "whether exposures change over time, of each camera of a rig and of the one of a film", 0, 1);
  visit("cameras.clock", c.cameras.clock, "whether each camera of a rig has a clock of its own", 0, 1);
  visit("cameras.exposure_rate", c.cameras.exposure_rate,
        "share of what is known of the gains that each step replaces", 1e-4, 1);
  visit("cameras.most_gain", c.cameras.most_gain, "largest gain of a camera; the least is one over it", 1,
        1000);
  visit("cameras.most_offset", c.cameras.most_offset,
        "largest offset of a camera's clock, intervals between its pictures", 0, 100);
  visit("cameras.clock_rate", c.cameras.clock_rate, "step of a clock, intervals between a camera's pictures",
        0, 1);
  visit("effects.steps", c.effects.steps, "steps of each trial fit, 0 = none is tried", 0, 1e6);
  visit("effects.min_gain", c.effects.min_gain, "dB on held-out pictures that an effect must gain", 0, 100);
  visit("effects.level", c.effects.level, "chance of a wrong switch-on, over all comparisons", 1e-6, 0.4);
  visit("effects.most_time", c.effects.most_time,
        "share of the seconds that loading left, after which no further effect is tried, 0 = all are", 0, 1);
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

}  // namespace splinevox
