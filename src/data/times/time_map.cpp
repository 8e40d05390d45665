// SPDX-License-Identifier: Apache-2.0
#include "data/times/time_map.hpp"

#include <algorithm>

#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

/// Of 0..1: control points are spread over all of it, so a scene in less of it would hardly have any.
constexpr double kSmallPart = 0.25;

bool in_unit(double t) { return t >= 0 && t <= 1; }

std::string count_of(std::size_t n, std::size_t all) {
  return std::to_string(n) + " of " + std::to_string(all) + " frames";
}

std::vector<double> times_of(const RawSplit& split) {
  std::vector<double> times;
  for (const RawFrame& frame : split.frames) times.push_back(frame.time);
  return times;
}

}  // namespace

TimeMap fit_time_map(const std::vector<double>& raw, bool part) {
  if (raw.empty()) return {};
  const auto [lo, hi] = std::minmax_element(raw.begin(), raw.end());
  if (*hi - *lo < 1e-9) return {*lo, 0};
  if (!part && in_unit(*lo) && in_unit(*hi) && *hi - *lo >= kSmallPart) return {};
  return {*lo, 1 / (*hi - *lo)};
}

TimeMap choose_time_map(const RawSplit* train, const std::vector<RawSplit>& splits,
                        std::vector<std::string>& notes, bool part) {
  if (train != nullptr) {
    const std::vector<double> times = times_of(*train);
    const TimeMap map = fit_time_map(times, part);
    const auto [lo, hi] = std::minmax_element(times.begin(), times.end());
    if (map.scale == 0)
      notes.push_back("train: every frame has the time " + time_text(*lo) + "; nothing can move");
    if (map.scale != 0 && map != TimeMap{})
      notes.push_back("train: times from " + time_text(*lo) + " to " + time_text(*hi) +
                      " are mapped to 0 to 1, in every split");
    return map;
  }
  for (const RawSplit& split : splits)
    for (std::size_t i = 0; i < split.frames.size(); ++i)
      if (!in_unit(split.frames[i].time))
        fail({split.where(i), "'time' is outside [0, 1] and there is no train split to map it by",
              "a number in [0, 1]", number(split.frames[i].time),
              "add " + transforms_name("train") + ", or pass the run's time map"});
  notes.push_back("there is no train split: times are taken as they are");
  return {};
}

void note_times(const RawSplit& split, const TimeMap& map, std::vector<std::string>& notes) {
  const std::size_t n = split.frames.size();
  std::vector<double> times = times_of(split);
  if (!std::is_sorted(times.begin(), times.end()))
    notes.push_back(split.name + ": frames are not in the order of time");
  const auto outside =
      std::size_t(std::count_if(times.begin(), times.end(), [&](double t) { return !in_unit(map(t)); }));
  if (outside > 0)
    notes.push_back(split.name + ": " + count_of(outside, n) + " lie outside the train split's times");
  std::sort(times.begin(), times.end());
  const auto distinct = std::size_t(std::unique(times.begin(), times.end()) - times.begin());
  if (distinct < n && map.scale != 0)
    notes.push_back(split.name + ": " + std::to_string(n) + " frames share " + std::to_string(distinct) +
                    " distinct times");
}

}  // namespace splinevox::data
