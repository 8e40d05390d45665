// SPDX-License-Identifier: Apache-2.0
#include "train/effects/film.hpp"

#include <algorithm>
#include <vector>

#include "train/bounds/seen_motion.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

/// 1 - cos over pairs of directions, of which only sums are known.
struct Angles {
  double sum = 0, pairs = 0;
  /// All pairs among n unit vectors.
  void add(const Vec3d& total, double n) {
    sum += (n * n - dot(total, total)) / 2;
    pairs += n * (n - 1) / 2;
  }
  double mean() const { return pairs > 0 ? std::max(0.0, sum / pairs) : 0; }
};

constexpr double kStands = 1e-4;  // a degree or so: a camera that stands

}  // namespace

double view_told_by_time(const Split& train, const Vec3& middle, double window) {
  const std::vector<int> order = frames_by_time(train);
  const std::size_t n = order.size();
  const auto time = [&](std::size_t i) { return train.frames[order[i]].time; };
  std::vector<Vec3d> direction(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d d = cast<double>(middle) - train.frames[order[i]].camera.position;
    direction[i] = dot(d, d) > 0 ? normalize(d) : Vec3d{0, 0, 1};
  }
  Angles near, all;
  Vec3d sum{}, total{};
  for (std::size_t i = 0, first = 0, last = 0; i < n; ++i) {
    // As far as the window, and the neighbours: a pause is no reason to look further elsewhere.
    const double from = std::min(time(i) - window / 2, time(i > 0 ? i - 1 : i)),
                 to = std::max(time(i) + window / 2, time(std::min(i + 1, n - 1)));
    while (last < n && time(last) <= to) sum = sum + direction[last++];
    while (time(first) < from) sum = sum - direction[first++];
    near.add(sum, double(last - first));
    total = total + direction[i];
  }
  all.add(total, double(n));
  return all.mean() > kStands ? std::clamp(1 - near.mean() / all.mean(), 0.0, 1.0) : 0;
}

double share_far(const VoxelModel& moving, const Split& views, float far) {
  constexpr int kCells = 32;  // along the longest edge
  double weight = 0, beyond = 0;
  for (const VisibleMotion& s : visible_motion(moving, views, {}, BitGrid(moving.box, kCells))) {
    weight += s.weight;
    if (length(s.offset) > far) beyond += s.weight;
  }
  return weight > 0 ? beyond / weight : 0;
}

}  // namespace splinevox
