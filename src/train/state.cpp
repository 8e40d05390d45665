// SPDX-License-Identifier: Apache-2.0
#include "train/state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/schedule.hpp"
#include "train/bounds/freeze.hpp"
#include "train/bounds/hidden.hpp"
#include "train/effects/effect_table.hpp"
#include "train/rates.hpp"
#include "train/refine.hpp"

namespace splinevox {
namespace {

/// A window of time is for what moves.
SamplingConfig sampling_of(const Config& config) {
  SamplingConfig out = config.sampling;
  if (!config.motion.enabled) out.window = 1;
  return out;
}

Volume starting_volume(const Setting& setting, const TimeMap& time_map) {
  const SceneBounds bounds = starting_bounds(setting.config, setting.train, setting.shown);
  return {Lattices(setting, time_map, bounds.box), {bounds.hull, {}, {}}, {}};
}

}  // namespace

Trainer::State::State(const Config& config, const Split& train, const TimeMap& time_map, Ranks* r,
                      std::unique_ptr<StepBackend> backend)
    : setting(config, train),
      ranks(r),
      home(starting_volume(setting, time_map), std::move(backend)),
      sampler(train, home.read().lattices.model.box, sampling_of(config), config.run.seed, setting.unit) {}

bool Trainer::State::refine(double progress_now) {
  progress = progress_now;
  const Config& config = setting.config;
  bool changed = false;
  const int wanted = std::max(0, reached(config.grid.radiance_start, progress));
  const bool changes = splinevox::changes(effects_of(config));
  int wanted_levels = changes ? reached(config.grid.motion_start, progress) + 1 : 0;
  const Basis& basis = basis_of(config.motion.basis);
  const int wanted_elevations =
      changes
          ? reached(basis.halves() ? config.motion.halve_start : config.motion.elevate_start, progress) + 1
          : 0;
  const bool elevates = elevations < wanted_elevations;
  const int wanted_emptied = reached(config.grid.empty_start, progress) + 1;
  const bool empties = emptied < wanted_emptied;
  const int wanted_order = order_at(config.radiance, progress);
  const bool joins = home.sh_order() < wanted_order;
  if (!(joins || stage < wanted || home.levels() < wanted_levels || elevates || empties)) return false;
  Volume& volume = home.change();
  Lattices& lattices = volume.lattices;
  const TimeWindow now = window();
  if (empties) {
    if (stage >= 0)
      changed = empty_hidden(setting, now, lattices);  // before the first stage there is nothing
    emptied = wanted_emptied;
  }
  const bool refines = clock.step > 0 && (stage < wanted || home.levels() < wanted_levels);
  if (refines && stage < wanted && now.whole) {
    tighten_box(setting, volume, now);
    sampler.set_box(lattices.model.box);
  }
  if (refines || changed) splinevox::refresh_occupancy(setting, volume, now);
  std::optional<Offset> offset;
  if (clock.step > 0 && stage < wanted)
    offset = freeze(setting, volume, now, lattices.edge() / float(config.grid.radiance[wanted]));
  const bool frozen = offset.has_value();
  if (frozen)  // they cost little now, and what is static is told from what moves as finely as they are
    wanted_levels = int(config.grid.motion.size());
  while (stage < wanted) {
    ++stage;
    if (stage == 0) {
      lattices.start_radiance(setting, volume.occupancy.hull);
    } else {
      const VoxelModel& model = lattices.model;
      const BitGrid matter = now.whole ? canonical_occupancy(model, config.sampling.occupancy_cells,
                                                             config.grid.prune_alpha, model.step)
                                       : volume.occupancy.hull;
      lattices.refine_radiance(setting, config.grid.radiance[stage], matter, std::exchange(offset, {}),
                               now.whole && config.grid.prune_alpha > 0);
    }
    changed = true;
  }
  if (joins) {
    lattices.add_harmonics(wanted_order);
    changed = true;
  }
  if (changes) {
    while (home.levels() < wanted_levels) {
      lattices.add_level(config.grid.motion[lattices.levels.size()], motion_cells(volume, now));
      changed = true;
    }
    while (elevations < wanted_elevations) {
      lattices.refine_curves(basis.halves() ? basis.refinement.refined(lattices.model.motion.points)
                                            : config.motion.elevate_points[elevations]);
      ++elevations;
      changed = true;
    }
  }
  if (changed) fit_lattices(volume);
  if (frozen) splinevox::refresh_occupancy(setting, volume, now);
  return changed;
}

void Trainer::State::fit_lattices(Volume& volume) const {
  set_rates(setting.config, volume.lattices);
  set_priors(setting.config, basis_of(setting.config.motion.basis).halves() ? elevations : 0,
             volume.lattices);
  fit_motion(setting, volume);
}

bool Trainer::State::occupancy_is_due() const {
  const int whole = setting.config.sampling.occupancy_every;
  const int every = window().whole ? whole : std::max(1, whole / 2);
  return clock.step > 0 && clock.step % every == 0;
}

void Trainer::State::draw() {
  sampler.draw(clock.step, progress, home.march_step(), home.background(), batch);
  batch.grids.clear();
  for (const int f : batch.frames) batch.grids.push_back(home.occupancy().grid_of(f));
}

RayLosses Trainer::State::ray_losses() const {
  const Config& c = setting.config;
  const double ramp = c.loss.ramp ? std::pow(0.01, 1 - progress) : 1.0;
  RayLosses losses;
  losses.stop = c.sampling.stop;
  losses.min_weight = c.sampling.min_weight;
  losses.seen_share = c.grid.seen_share;
  losses.faintest = kHalfLevel * setting.unit;
  losses.motion.offset = float(c.loss.offset * ramp);
  losses.motion.offset_rigidity = c.loss.offset_rigidity;
  losses.motion.offset_softening = 1e-4f * home.march_step();
  losses.motion.divergence = float(c.loss.divergence * ramp);
  losses.motion.hutchinson = c.loss.divergence_kind == DivergenceKind::hutchinson;
  losses.probe_seed = batch.draw;
  return losses;
}

StepInput Trainer::State::step_input() const {
  const OptimiserConfig& o = setting.config.optimiser;
  const LossConfig& loss = setting.config.loss;
  StepInput in{};
  in.rays = batch.rays;
  in.targets = batch.targets;
  in.tasks = batch.tasks;
  in.times = batch.times;
  in.occupancy = batch.grids;
  in.background = &home.background();
  in.losses = ray_losses();
  in.tv_scale = float(std::pow(double(loss.tv_final), progress));
  in.tv_share = loss.tv_share;
  in.draw = batch.draw;
  in.factors = moment_factors(o.kind == OptimiserKind::adam ? o.beta1 : 0.0, o.beta2, o.epsilon,
                              double(clock.step + 1));
  in.radiance_rate = float(cosine_decay(progress, o.final_radiance));
  in.motion_rate = float(cosine_decay(progress, o.final_motion));
  return in;
}

void Trainer::State::learn_background(const StepInput& in, const BackgroundGradient& gradient) {
  if (home.background().learned())
    update(home.background(), background, gradient, in.factors,
           setting.config.optimiser.lr_background * in.radiance_rate);
}

void Trainer::State::archive(Archive& a) {
  a.section("steps", [&] { a(clock.step, stage, elevations, emptied); });
  a.section("clock", [&] { a(clock.seconds, clock.seconds_at_start, clock.phases); });
  home.archive(a, setting);
  a.section("background", [&] {
    const int order = home.background().order;
    a(home.background(), background);
    check_fits(home.background().order == order);
  });
  if (!a.reading()) return;
  check_fits(stage >= 0 && stage < int(setting.config.grid.radiance.size()));
  Volume& volume = home.change();
  sampler.set_box(volume.lattices.model.box);
  fit_lattices(volume);
}

}  // namespace splinevox
