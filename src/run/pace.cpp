// SPDX-License-Identifier: Apache-2.0
#include "run/pace.hpp"

#include <algorithm>
#include <limits>

namespace splinevox::run {
namespace {

constexpr double kTold = 2;     // seconds from which a pace can be told
constexpr double kLate = 0.25;  // of the time so far, over which it is measured
constexpr double kFixed = 40;   // cells that what does not grow with the lattice costs as much as

}  // namespace

Pace::Pace(const Config& config)
    : by_clock_(config.run.max_time > 0), growth_(config.sampling.growth), stages_() {
  for (std::size_t i = 0; i < config.grid.radiance.size(); ++i)
    stages_.push_back({config.grid.radiance_start[i], double(config.grid.radiance[i])});
}

void Pace::add(const StepReport& report) { marks_.push_back({report.progress, report.seconds}); }

/// Of the steps between two progresses, in any unit: the integral of (1 + (growth - 1) p) (cells(p) +
/// kFixed).
double Pace::cost(double from, double to) const {
  const auto rays = [&](double p) { return p + (growth_ - 1) * p * p / 2; };
  double sum = 0;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const double end =
        i + 1 < stages_.size() ? stages_[i + 1].start : std::numeric_limits<double>::infinity();
    const double a = std::max(from, stages_[i].start), b = std::min(to, end);
    if (a < b) sum += (stages_[i].cells + kFixed) * (rays(b) - rays(a));
  }
  return sum;
}

std::optional<double> Pace::left() const {
  if (marks_.empty()) return {};
  const Mark &first = marks_.front(), &last = marks_.back();
  if (by_clock_)
    return last.progress > 0 ? std::optional(last.seconds / last.progress - last.seconds) : std::nullopt;
  const double took = last.seconds - first.seconds;
  if (took < kTold) return {};
  const double since = last.seconds - std::max(kTold, kLate * took);
  const auto after = std::upper_bound(marks_.begin(), marks_.end(), since,
                                      [](double seconds, const Mark& m) { return seconds < m.seconds; });
  const Mark& mark = after == marks_.begin() ? first : *std::prev(after);
  const double done = cost(mark.progress, last.progress);
  if (done <= 0) return {};
  return (last.seconds - mark.seconds) * cost(last.progress, 1) / done;
}

}  // namespace splinevox::run
