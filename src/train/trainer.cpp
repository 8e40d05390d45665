// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/trainer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/stopwatch.hpp"
#include "splinevox/core/error.hpp"
#include "train/state.hpp"

namespace splinevox {

Trainer::Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used,
                 Ranks* ranks, std::unique_ptr<StepBackend> backend) {
  validate(config);
  check_learns_depth(*backend, config, train);
  check_learns_tracks(*backend, config, train);
  Stopwatch watch;
  state_ = std::make_unique<State>(config, train, time_map, ranks, std::move(backend));
  state_->refine(0);
  RunClock& clock = state_->clock;
  clock.seconds = seconds_used + watch.lap();
  if (ranks) clock.seconds = ranks->from_first(clock.seconds);
  clock.seconds_at_start = clock.seconds;
}

Trainer::Trainer(const Config& config, const Split& train, const TimeMap& time_map, double seconds_used,
                 Ranks* ranks, Device device, bool deterministic)
    : Trainer(config, train, time_map, seconds_used, ranks, make_step(device, deterministic, ranks)) {}

Trainer::~Trainer() = default;

void Trainer::set_loss(ColourLoss loss) {
  if (loss && !state_->home.takes_colour_gradient())
    fail({"Trainer::set_loss", "a loss of one's own is asked for on the CPU alone, and in one process",
          "Device::cpu without ranks", "another device, or ranks", ""});
  state_->own_loss = std::move(loss);
}

bool Trainer::done() const { return state_->clock.used(state_->setting.config.run) >= 1; }

StepReport Trainer::step(double seconds_outside) {
  RunClock& clock = state_->clock;
  const double before = clock.seconds;
  StepReport report = one_step();
  clock.seconds += seconds_outside;
  if (state_->ranks)  // clocks differ, schedules must not
    clock.seconds = state_->ranks->from_first(clock.seconds);
  clock.drawn += report.rays;
  clock.drawing += clock.seconds - before;
  report.seconds = clock.seconds;
  return report;
}

StepReport Trainer::one_step() {
  State& s = *state_;
  const RunConfig& run = s.setting.config.run;
  Stopwatch watch;
  const auto lap = [&](double PhaseSeconds::*phase) { s.clock.spend(phase, watch.lap()); };

  StepReport report;
  report.stage_changed = s.refine(s.clock.position(run));
  lap(&PhaseSeconds::refine);
  if (!report.stage_changed && s.occupancy_is_due()) s.refresh_occupancy();
  s.fit_depths();
  lap(&PhaseSeconds::occupancy);

  s.draw();
  lap(&PhaseSeconds::slices);

  // Slice, forward and backward, scatter, regularise, update.
  const StepInput in = s.step_input();
  const StepSums sums = s.home.step(in);
  s.clock.spend(sums, watch.lap());

  report.step = ++s.clock.step;
  report.rays = std::int64_t(s.batch.rays.size());
  report.samples = sums.samples;
  report.progress = s.clock.used(run);
  if (!sums.usable) return s.discard(sums, report);
  s.discarded.clear();
  s.learn_background(in, sums.background);
  s.learn_cameras(in, sums);
  lap(&PhaseSeconds::update);

  report.progress = s.clock.used(run);
  report.loss = (s.lost.value_or(sums.squared_error) + sums.motion_loss + sums.depth_loss + sums.track_loss) /
                double(report.rays);
  report.psnr = -10 * std::log10(std::max(1e-10, sums.squared_error / (3.0 * double(report.rays))));
  return report;
}

void Trainer::add_time(double seconds) { state_->clock.added += seconds; }

const std::vector<StepReport>& Trainer::discarded() const { return state_->discarded; }

VoxelModel Trainer::model() const {
  const Volume& volume = state_->home.read();
  VoxelModel model = volume.lattices.model;
  clear_skipped(state_->setting, model);
  return model;
}

VoxelModel Trainer::finish() {
  State& s = *state_;
  VoxelModel model = s.home.take();
  clear_skipped(s.setting, model);
  return model;
}

const CameraFits& Trainer::cameras() const { return state_->home.cameras(); }

PhaseSeconds Trainer::phases() const { return state_->clock.phases; }

const Config& Trainer::settings() const { return state_->setting.config; }
double Trainer::moving_share() const { return state_->home.moving_share(); }

double Trainer::seconds() const { return state_->clock.seconds; }

void Trainer::save(const std::function<void(std::span<const std::string_view>)>& take) const {
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
  state_->archive(archive);
  if (!archive.exhausted())
    fail({"checkpoint", "the training state goes on after its end",
          "a state written by the same version and configuration", "more bytes", ""});
}

}  // namespace splinevox
