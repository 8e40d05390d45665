// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
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
  bool paced = true;  ///< by the clock, smaller batches and no finest lattices where there is time for few
                      ///< steps (train/paced.hpp)
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
  int few_cells = 0;  ///< the most of those where cameras stand still at fewer places than loss.tv_places
                      ///< (for_places in train/start.hpp); 0: as everywhere
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
                                   ///< since the emptying before; empty: never, and total variation takes
                                   ///< rows that no ray made visible, too
  float seen_share = 0.25f;  ///< of the heaviest sample of a ray: samples from this weight on are visible
};

struct RadianceConfig {
  int sh_order = 1;             ///< -1 (none), 0..3
  std::vector<float> sh_start;  ///< progress at which the harmonics of order 1, 2, ... join, the last for all
                                ///< that follow; empty: at the start
  float initial_alpha = 0.01f;  ///< alpha of one step of the first lattice before training
  float opaque_alpha = 0.05f;   ///< the same behind opaque pictures, if it is more
  float steepen = 0;  ///< power of a lattice's fineness by which its density is steeper than the first's; not
                      ///< where there is presence (Lattices::refine_radiance)
  float outer_alpha = 0.02f;  ///< of each of a ray's samples in the surroundings before training
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
  float rest = 0.35f;                ///< static regions freeze if at most this share of what is visible moves
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
  int tv_places = 96;   ///< places of cameras that stand still, below which tv_density grows in proportion
                        ///< (for_places in train/start.hpp); 0: never
  float depth = 1;      ///< of the relative error of a ray's distance, where a depth map tells it
  float tracks = 0.1f;  ///< of how far apart rays of two moments see one tracked point (kTrackWidth)
  float transmittance = 0;           ///< of T (1 - T) of a ray: it ends on something or passes
  float transmittance_start = 0.3f;  ///< progress at which that begins
  float offset = 0;                  ///< lambda_off of Eq. 8
  float offset_rigidity = 0.3f;      ///< lambda_r of Eq. 6
  float divergence = 0;              ///< lambda_div of Eq. 8
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
  float carve_speed = 3;     ///< the fastest that things are taken to move, picture widths per unit of model
                             ///< time, or per 240 moments of a longer sequence
  float changing = 0.3f;     ///< share of the rays, where cameras that stand still see something change
  float hard_share = 0.5f;   ///< share of a picture's rays that are drawn by where it is fitted worst
  float hard_start = 0.15f;  ///< progress at which that begins
  float hard_undo = 0.5f;    ///< how far weights of the loss undo it: 0 not, 1 all of it
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
  int steps = 200;         ///< of each trial fit; 0: every effect of the configuration is used untried
  float min_gain = 0.1f;   ///< dB on held-out pictures below which an effect is not worth having
  float level = 0.01f;     ///< chance of switching on any effect that gains less, over all comparisons
  float most_time = 0.4f;  ///< share of what loading left of run.max_time, after which no further effect is
                           ///< tried; 0: all are
};

/// What is learned of the cameras of a rig (train/cameras.hpp).
struct CamerasConfig {
  bool exposure = true;         ///< a gain per camera and channel: exposure and white balance
  bool drift = true;            ///< gains that change over time, also of the one camera of a film
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
/// Grids that the model of a finished run has, of kMostGrids at most.
int grids_at_end(const Config& config);

}  // namespace splinevox
