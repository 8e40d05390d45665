// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/trainer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "core/atomic_file.hpp"
#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "math/schedule.hpp"
#include "splinevox/core/error.hpp"
#include "train/config/loss_terms.hpp"
#include "train/ranks.hpp"
#include "train/state.hpp"

namespace splinevox {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Share of the budget used: of the time, the steps, or whichever of the two is further.
double budget_used(const Config& config, std::int64_t step, double seconds) {
  double p = 0;
  if (config.run.max_time > 0) p = std::max(p, seconds / config.run.max_time);
  if (config.run.max_steps > 0) p = std::max(p, double(step) / config.run.max_steps);
  return std::min(p, 1.0);
}

/// Where the schedules stand, 0..1: by the clock, by the steps, or by whichever of the two is further.
template <class State>
double schedule_position(const State& s) {
  const RunConfig& run = s.config.run;
  double p = 0;
  if (run.max_time > 0)
    p = std::max(p, clock_progress(s.seconds_before, s.seconds_at_start, run.max_time, run.late_cost));
  if (run.max_steps > 0) p = std::max(p, double(s.step) / run.max_steps);
  return std::min(p, 1.0);
}

/// Remembers a discarded step; after too many in a row, back to the last good one and an error.
template <class State>
StepReport give_up_after_many(State& s, const StepReport& report) {
  s.discarded.push_back(report);
  if (int(s.discarded.size()) < Trainer::kMostDiscarded) return report;
  s.step -= Trainer::kMostDiscarded;
  std::string got = std::to_string(report.bad_rows) + " rows of the gradient";
  if (!report.bad_rays.empty())
    got += ", from ray " + std::to_string(report.bad_rays[0].index) + " of training view " +
           std::to_string(report.bad_rays[0].frame) + " first";
  else
    got += s.ranks ? ", from no ray of this process" : ", from no ray: from a regulariser";
  throw Error({"step " + std::to_string(s.step + 1),
               std::to_string(Trainer::kMostDiscarded) +
                   " steps in a row were not finite; the model is as it was before them",
               "finite losses and gradients", got,
               "smaller weights of losses and smaller learning rates (--set loss... and optimiser...)"},
              Fault::numeric);
}

/// The report of a step that was made.
template <class State>
StepReport finished(const State& s, StepReport report, double squared_error, double motion_loss,
                    std::int64_t samples) {
  const double rays = double(report.rays);
  report.step = s.step;
  report.seconds = s.seconds_before;
  report.progress = budget_used(s.config, s.step, s.seconds_before);
  report.samples = samples;
  report.loss = (squared_error + motion_loss) / rays;
  report.psnr = -10 * std::log10(std::max(1e-10, squared_error / (3.0 * rays)));
  return report;
}

/// The finest level takes the gradient of the sum of all levels as it is...
void take_motion_gradient(Gradient& sum, Learner& finest) {
  std::swap(finest.gradient.values.values, sum.values.values);
  std::swap(finest.gradient.touched, sum.touched);
}

/// ... and each coarser one the transpose of its prolongation.
void spread_motion_gradient(std::vector<Learner>& learners) {
  for (std::size_t l = learners.size() - 1; l > 0; --l) {
    const Gradient& fine = learners[l].gradient;
    Gradient& coarse = learners[l - 1].gradient;
    parallel_for(coarse.values.topology->brick_count(), [&](int index) {
      restrict_brick(fine.values, fine.touched, coarse.values, index + 1, coarse.touched[index + 1]);
    });
  }
}

}  // namespace

bool Trainer::State::discard(const PassResult& pass, const std::vector<double>& times, StepReport& report) {
  const auto count = [&] {
    std::int64_t rows = unusable_rows(radiance.gradient);
    for (const Learner& learner : level_learners) rows += unusable_rows(learner.gradient);
    return rows;
  };
  // What the losses of Eq. 9 add is no larger than their weights, so only very large ones need another look.
  const bool spoilt = can_spoil_gradients(in_scene_units(config.loss, edge));
  if (pass.usable && !(spoilt && count() > 0)) return false;
  const std::int64_t bad_rows = count();
  splinevox::discard(radiance.gradient);
  for (Learner& learner : level_learners) splinevox::discard(learner.gradient);
  report_discarded(pass.samples, bad_rows, engine->bad_rays(), times, report);
  return true;
}

void Trainer::State::report_discarded(std::int64_t samples, std::int64_t bad_rows,
                                      const std::vector<int>& bad, const std::vector<double>& times,
                                      StepReport& report) {
  report.bad_rows = bad_rows;
  report.discarded = true;
  report.seconds = seconds_before, report.progress = budget_used(config, step, seconds_before);
  report.samples = samples;
  report.loss = report.psnr = std::numeric_limits<double>::quiet_NaN();
  std::vector<int> slot(batch.rays.size());
  for (const Batch::Task& task : batch.tasks)
    std::fill(slot.begin() + task.first, slot.begin() + task.last, task.frame);
  for (const int i : bad) {
    if (report.bad_rays.size() == kBadRaysKept) break;
    const RayInput<float>& ray = batch.rays[i];
    report.bad_rays.push_back(
        {batch.frames[slot[i]], i, ray.origin, ray.direction, batch.targets[i], times[slot[i]]});
  }
}

Trainer::Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used,
                 Ranks* ranks, std::unique_ptr<StepBackend> device) {
  validate(config);
  const auto start = Clock::now();
  state_ = std::make_unique<State>(config, train, time_map);
  state_->ranks = ranks, state_->device = std::move(device);
  state_->refine(0);
  state_->seconds_before = seconds_used + since(start);
  if (ranks) state_->seconds_before = ranks->from_first(state_->seconds_before);
  state_->seconds_at_start = state_->seconds_before;
}

Trainer::~Trainer() = default;

bool Trainer::done() const { return budget_used(state_->config, state_->step, state_->seconds_before) >= 1; }

StepReport Trainer::step(double seconds_outside) {
  StepReport report = one_step();
  state_->seconds_before += seconds_outside;
  if (state_->ranks)
    state_->seconds_before =
        state_->ranks->from_first(state_->seconds_before);  // clocks differ, schedules must not
  report.seconds = state_->seconds_before;
  return report;
}

StepReport Trainer::one_step() {
  State& s = *state_;
  const Config& c = s.config;
  auto clock = Clock::now();
  const auto lap = [&](double& phase) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - clock).count();
    phase += seconds, s.seconds_before += seconds;
    clock = now;
  };
  StepReport report;
  const double progress = schedule_position(s);
  report.stage_changed = s.refine(progress);
  lap(s.phases.refine);
  const int every = s.growing() ? std::max(1, c.sampling.occupancy_every / 2) : c.sampling.occupancy_every;
  if (s.step > 0 && s.step % every == 0 && !report.stage_changed) s.refresh_occupancy();
  lap(s.phases.occupancy);

  if (!s.device) s.collapse_levels(s.active.rows);
  s.sampler.draw(s.step, progress, s.model.step, s.model.background, s.batch);
  report.rays = std::int64_t(s.batch.rays.size());
  if (!s.radiance.gradient.seen.empty()) s.rays_shown += report.rays;
  if (s.ranks) s.device ? keep_own_rays(*s.ranks, s.batch) : keep_own_share(*s.ranks, s.batch);
  s.behind.resize(s.model.background.learned() ? s.batch.rays.size() : 0);
  std::vector<double> times;
  std::vector<const BitGrid*> occupancy;
  for (const int f : s.batch.frames) {
    times.push_back(s.train.frames[f].time);
    occupancy.push_back(s.occupancy.empty()       ? &s.bounds.hull
                        : s.occupancy.size() == 1 ? &s.occupancy[0]
                                                  : &s.occupancy[f]);
  }
  lap(s.phases.slices);

  const double ramp = c.loss.ramp ? std::pow(0.01, 1 - progress) : 1.0;
  RayLosses losses;
  losses.stop = c.sampling.stop, losses.min_weight = c.sampling.min_weight;
  losses.seen_share = c.grid.seen_share, losses.faintest = kHalfLevel * s.unit;
  losses.motion.offset = float(c.loss.offset * ramp), losses.motion.offset_rigidity = c.loss.offset_rigidity;
  losses.motion.offset_softening = 1e-4f * s.model.step;
  losses.motion.divergence = float(c.loss.divergence * ramp);
  losses.motion.hutchinson = c.loss.divergence_kind == DivergenceKind::hutchinson;
  const std::uint64_t draw = hash64(c.run.seed ^ hash64(std::uint64_t(s.step)));
  losses.probe_seed = draw;
  if (s.device) {
    const StepSums sums = s.step_on_device(losses, times, progress);
    lap(s.phases.rays);
    if (sums.bad_rays + sums.bad_rows > 0) {
      s.report_discarded(sums.samples, sums.bad_rows, s.device->bad_rays(), times, report);
      report.step = s.step;
      return give_up_after_many(s, report);
    }
    s.discarded.clear();
    s.learn_background(progress);
    lap(s.phases.update);
    return finished(s, report, sums.squared_error, sums.motion_loss, sums.samples);
  }
  PassResult pass = s.engine->run(s.model, s.active, s.model.step, s.batch, times, occupancy, losses,
                                  s.radiance.gradient, s.motion_gradient, s.behind);
  clock = Clock::now();
  s.phases.slices += pass.slice_seconds, s.phases.rays += pass.ray_seconds,
      s.phases.scatter += pass.scatter_seconds;
  s.seconds_before += pass.slice_seconds + pass.ray_seconds + pass.scatter_seconds;

  if (s.ranks) {
    pass = sum_over_ranks(*s.ranks, pass);
    if (!sum_over_ranks(*s.ranks, s.radiance.gradient)) pass.usable = false;
    if (!s.levels.empty() && !sum_over_ranks(*s.ranks, s.motion_gradient)) pass.usable = false;
    lap(s.phases.scatter);
  }
  const MotionField& motion = s.model.motion;
  if (!s.levels.empty()) {
    take_motion_gradient(s.motion_gradient, s.level_learners.back());
    add_curve_prior(motion.levels[0], s.level_learners.back(), motion, s.rest_prior(), c.loss.tv_share,
                    draw + s.levels.size(), s.active.rows);
    spread_motion_gradient(s.level_learners);
  }
  lap(s.phases.slices);
  const float tv = float(std::pow(double(c.loss.tv_final), progress));
  add_total_variation(s.model.radiance.raw, s.radiance, tv, c.loss.tv_share, draw);
  for (std::size_t l = 0; l < s.levels.size(); ++l) {
    add_total_variation(s.levels[l], s.level_learners[l], tv, c.loss.tv_share, draw + 1 + l);
    add_curve_prior(s.levels[l], s.level_learners[l], motion, s.curve_prior(), c.loss.tv_share, draw + 1 + l);
  }
  lap(s.phases.regularise);

  ++s.step;
  report.step = s.step;
  if (s.discard(pass, times, report)) return give_up_after_many(s, report);
  s.discarded.clear();
  const MomentFactors factors = s.factors();
  update(s.model.radiance.raw, s.radiance, factors,
         float(cosine_decay(progress, c.optimiser.final_radiance)));
  for (std::size_t l = 0; l < s.levels.size(); ++l)
    update(s.levels[l], s.level_learners[l], factors,
           float(cosine_decay(progress, c.optimiser.final_motion)));
  s.learn_background(progress);
  lap(s.phases.update);

  return finished(s, report, pass.squared_error, pass.motion_loss, pass.samples);
}

const std::vector<StepReport>& Trainer::discarded() const { return state_->discarded; }

VoxelModel Trainer::model() const {
  state_->bring_home();
  state_->collapse_levels({});
  VoxelModel model = state_->model;
  state_->clear_skipped(model);
  return model;
}

VoxelModel Trainer::finish() {
  State& s = *state_;
  s.bring_home();
  s.collapse_levels({});
  s.device.reset(), s.engine.reset();
  s.radiance = {}, s.motion_gradient = {};
  s.levels.clear(), s.level_learners.clear(), s.partial_sums.clear();
  VoxelModel model = std::move(s.model);
  s.clear_skipped(model);
  return model;
}

PhaseSeconds Trainer::phases() const { return state_->phases; }

double Trainer::moving_share() const { return state_->moving_share; }

double Trainer::seconds() const { return state_->seconds_before; }

void Trainer::save(const std::function<void(std::span<const std::string_view>)>& take) const {
  state_->bring_home();
  Archive archive;
  state_->archive(archive);
  take(archive.pieces());
}

std::vector<char> Trainer::save() const {
  std::vector<char> bytes;
  save([&](std::span<const std::string_view> pieces) { bytes = joined(pieces); });
  return bytes;
}

void Trainer::restore(const std::vector<char>& bytes) {
  Archive archive(bytes);
  state_->home = true, state_->uploaded = false;
  state_->archive(archive);
  if (!archive.exhausted())
    fail({"checkpoint", "the training state goes on after its end",
          "a state written by the same version and configuration", "more bytes", ""});
}

}  // namespace splinevox
