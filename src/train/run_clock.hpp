// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#include "backend/step.hpp"
#include "math/schedule.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/paced.hpp"

namespace splinevox {

/// How far a run is: its steps, and its seconds.
struct RunClock {
  std::int64_t step = 0;        ///< steps made, those discarded included
  double seconds = 0;           ///< of the budget: loading and earlier sessions included
  double seconds_at_start = 0;  ///< of those, used before the first step
  double added = 0;             ///< seconds by which the budget has grown while the run went on
  PhaseSeconds phases;
  std::int64_t drawn = 0;  ///< rays of this session's steps
  double drawing = 0;      ///< seconds that they took

  /// Share of the budget used: of the time, the steps, or whichever of the two is further.
  double used(const RunConfig& run) const {
    return further(run.max_time > 0 ? seconds / budget(run) : 0, run);
  }
  /// Where the schedules stand, 0..1: by the clock, by the steps, or by whichever of the two is further.
  double position(const RunConfig& run) const {
    const bool timed = run.max_time > 0;
    return further(timed ? clock_progress(seconds, seconds_at_start, budget(run), run.late_cost) : 0, run);
  }
  void spend(double PhaseSeconds::*phase, double time) {
    phases.*phase += time;
    seconds += time;
  }
  /// A backend's step. What it does not tell apart counts as rays.
  void spend(const StepSums& sums, double time) {
    const double rays =
        time - sums.slice_seconds - sums.scatter_seconds - sums.regularise_seconds - sums.update_seconds;
    spend(&PhaseSeconds::slices, sums.slice_seconds);
    spend(&PhaseSeconds::scatter, sums.scatter_seconds);
    spend(&PhaseSeconds::regularise, sums.regularise_seconds);
    spend(&PhaseSeconds::update, sums.update_seconds);
    spend(&PhaseSeconds::rays, rays);
  }

  /// Steps with all rays of the configuration, on the mean over the run, that the seconds of the budget pay
  /// for, by the pace of this session so far. None: it is not known yet. Infinite where steps are counted.
  std::optional<double> batches(const Config& config) const {
    constexpr double kKnown = 0.03;  // of the budget
    const RunConfig& run = config.run;
    if (!run.paced || !by_clock(run)) return std::numeric_limits<double>::infinity();
    if (drawing < kKnown * budget(run)) return {};
    const double rays = double(drawn) / drawing * (budget(run) - seconds_at_start);
    return rays / (0.5 * (1 + config.sampling.growth) * config.sampling.rays);
  }

 private:
  double budget(const RunConfig& run) const { return run.max_time + added; }
  double further(double by_time, const RunConfig& run) const {
    const double by_steps = run.max_steps > 0 ? double(step) / run.max_steps : 0;
    return std::min(std::max(by_time, by_steps), 1.0);
  }
};

}  // namespace splinevox
