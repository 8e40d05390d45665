// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <vector>

#include "backend/step.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/archive.hpp"
#include "train/batch.hpp"
#include "train/bounds/hull.hpp"
#include "train/bounds/offset.hpp"
#include "train/engine.hpp"
#include "train/learn_background.hpp"
#include "train/optimiser.hpp"
#include "train/refine.hpp"
#include "train/start.hpp"

namespace splinevox {

/// Raw density of what is absent: an alpha of about 1e-6 a step, low enough to be nothing and near enough to
/// learn back from.
inline constexpr float kEmptyDensity = -10;

/// Parameters and everything else a run carries from step to step.
struct Trainer::State {
  State(const Config& config, const Split& train, const TimeMap& time_map);

  const Shown shown;
  const float unit;     ///< of brightness; 1 unless the scene is dark
  const Config config;  ///< in that unit
  const Split& train;
  Ranks* ranks = nullptr;  ///< who trains with us; null: nobody
  SceneBounds bounds;
  float edge = 1;  ///< longest edge of the box, scene units: the unit of lr_control
  BatchSampler sampler;
  std::unique_ptr<Engine> engine;  ///< compiled for the effects that the lattices of now have
  bool engine_moves = false;
  int engine_order = -1;

  VoxelModel model;  ///< motion.levels: the sum of the active levels
  Learner radiance;
  BackgroundLearner background;  ///< of model.background, if that is learned
  std::vector<Channels> levels;  ///< active motion levels, coarse to fine; the learned parameters
  std::vector<Learner> level_learners;
  std::vector<Channels> partial_sums;  ///< of the levels up to each but the last
  BitGrid awake;            ///< cells of the box in which motion is learned; no cells: everywhere (settle)
  double moving_share = 1;  ///< of what pictures show, when it last came to rest
  std::vector<RowMask> awake_rows;  ///< rows of the finest level in their reach, [bricks + 1], the others
                                    ///< rest; empty: nothing rests
  ActiveRows active;                ///< of the finest level, until the next refresh
  Gradient motion_gradient;         ///< of the summed level
  std::vector<BitGrid> occupancy;   ///< per training frame; empty: the hull stands for all

  std::int64_t step = 0;
  double progress = 0;          ///< of the last refine
  int stage = -1;               ///< radiance stage
  int elevations = 0;           ///< refinements of the curves done: halvings, or degree elevations
  int emptied = 0;              ///< times that unseen matter was to be emptied
  std::int64_t rays_shown = 0;  ///< since radiance.gradient.seen was begun
  double seconds_before = 0;    ///< of earlier sessions and of loading
  double seconds_at_start = 0;  ///< of those, used before the first step
  PhaseSeconds phases;
  Batch batch;
  std::vector<Vec3> behind;             ///< gradient of the colour behind each ray, where it is learned
  std::unique_ptr<StepBackend> device;  ///< makes the steps, if any does
  bool uploaded = false;                ///< the device has the parameters, and the latest
  bool home = true;                     ///< so have the arrays here
  std::vector<StepReport> discarded;    ///< the last steps, as far as they were discarded in a row

  /// Whether a step's loss or gradients cannot be used. If so, forgets them and fills in the report.
  bool discard(const PassResult& pass, const std::vector<double>& times, StepReport& report);
  /// The report of a step that changed nothing.
  void report_discarded(std::int64_t samples, std::int64_t bad_rows, const std::vector<int>& bad,
                        const std::vector<double>& times, StepReport& report);

  /// The parameters as the device left them, before anything here reads or changes them.
  void bring_home();
  /// A step's rays, gradients and update on the device.
  StepSums step_on_device(const RayLosses& losses, const std::vector<double>& times, double progress);
  /// What Adam needs for the step that `step` counts.
  MomentFactors factors() const;
  /// A step on the background, if it is learned, from `behind`.
  void learn_background(double progress);
  /// Whether some times are yet to be trained (SamplingConfig::window): nothing may be taken to be empty for
  /// good.
  bool growing() const { return !sampler.whole(progress); }
  /// Brings lattices, levels and degree to what the progress asks for. True if anything changed.
  bool refine(double progress_now);
  /// model.motion.levels = sum of the active levels.
  /// Rows outside `rows` ([bricks + 1] of the finest level; empty: all rows) keep what they had.
  void collapse_levels(const std::vector<RowMask>& rows);
  void refresh_occupancy();
  /// Empties the canonical cells that the occupancy calls empty: what training skipped it never looked at
  /// again, and leftovers of the first fog would show in a picture. Bricks of which nothing is left go.
  void clear_skipped(VoxelModel& model) const;
  void set_rates();
  /// The configuration's priors on curves, whose lengths are edges of the box, in scene units.
  CurvePrior curve_prior() const;
  RestPrior rest_prior() const;
  void archive(Archive& a);

 private:
  /// Shrinks the box, and every lattice with it, to where the model has matter at some training time. The
  /// occupancy must be refreshed after it.
  void tighten_box();
  /// Puts a motion on the levels' lattices of the box, in bricks near the cells. They keep it up to sampling
  /// it, and forget their moments.
  void put_on_levels(const Channels& sum, const BitGrid& cells);
  /// Lays motion to rest where it is none, if that is in most of what is seen; see rest.cpp. Returns the
  /// offset at which the canonical volume is to be looked at from now on; none if nothing comes to rest. The
  /// occupancy must be refreshed after both. @param voxel  of the next stage, scene units
  std::optional<Offset> settle(float voxel);
  /// For every change of the finest level's lattice or of what is awake.
  void find_awake_rows();
  void start_radiance();
  /// Empties the canonical rows that no ray has shown, if there were rays enough, and begins to look anew.
  /// Returns whether bricks went by it.
  bool empty_unseen();
  /// Lets go of the bricks in whose cells nothing is left, here and in arrays of rows beside them: pictures
  /// stay as they are but for the millionth of light that an empty step takes. Returns whether any went.
  static bool drop_empty(Channels& raw, std::initializer_list<AlignedVector<float>*> beside = {});
  /// Begins to look anew (Gradient::seen).
  void forget_seen();
  /// Harmonics up to an order from now on, those that join as 0 in rows as wide as it takes: every picture
  /// stays as it is, and moments are kept.
  void add_harmonics(int order);
  void refine_radiance(int cells, const std::optional<Offset>& offset);
  void add_level(int cells);
  /// Rates, summed motion, gradients and engine for the lattices as they are now.
  void fit_lattices();
  BitGrid occupied_ever() const;
  BitGrid swept() const;
  void find_active();
  std::vector<BitGrid> frame_occupancies(float alpha) const;
};

}  // namespace splinevox
