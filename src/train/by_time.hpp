// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numeric>
#include <set>
#include <span>
#include <vector>

#include "data/times/seen_moments.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Moments of which a longer sequence has more: it shows more of a motion, or the same again and again.
inline constexpr std::size_t kLongSequence = 240;

/// Indices of a split's frames in order of time; frames of one moment stay in the split's order.
inline std::vector<int> frames_by_time(const Split& split) {
  std::vector<int> out(split.frames.size());
  std::iota(out.begin(), out.end(), 0);
  std::stable_sort(out.begin(), out.end(),
                   [&](int a, int b) { return split.frames[a].time < split.frames[b].time; });
  return out;
}

/// Where a moment begins in a list of frames in order of time. @param time_of  of a frame
template <class TimeOf>
std::vector<std::size_t> starts_of_moments(std::span<const int> frames, const TimeOf& time_of) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (i == 0 || time_of(frames[i]) != time_of(frames[i - 1])) out.push_back(i);
  return out;
}

/// When each camera took pictures, by camera_id; frames of no known camera are left out.
inline std::vector<std::set<double>> times_of_cameras(const Split& split) {
  std::vector<std::set<double>> out;
  for (const Frame& f : split.frames) {
    if (f.camera_id < 0) continue;
    if (f.camera_id >= int(out.size())) out.resize(std::size_t(f.camera_id) + 1);
    out[std::size_t(f.camera_id)].insert(f.time);
  }
  return out;
}

/// The moments of the scene that a split shows.
inline std::set<double> moments_of(const Split& split) {
  std::set<double> all;
  for (const Frame& f : split.frames) all.insert(f.time);
  return scene_moments(times_of_cameras(split), all);
}

/// Of a long split a few hundred frames, evenly: enough for what all of its pictures tell together.
inline std::vector<const Frame*> some_frames(const Split& split) {
  constexpr std::size_t kMost = 512;
  const std::size_t n = split.frames.size(), count = std::min(n, kMost);
  std::vector<const Frame*> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = &split.frames[i * n / count];
  return out;
}

}  // namespace splinevox
