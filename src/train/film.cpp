// SPDX-License-Identifier: Apache-2.0
#include "film.hpp"

#include <vector>

#include "by_time.hpp"
#include "seen_motion.hpp"

namespace splinevox {

double shared_direction(const Split& train, const Vec3& middle, double window) {
  const std::vector<int> order = frames_by_time(train);
  const std::size_t n = order.size();
  const auto time = [&](std::size_t i) { return train.frames[order[i]].time; };
  std::vector<Vec3d> direction(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d d = cast<double>(middle) - train.frames[order[i]].camera.position;
    direction[i] = dot(d, d) > 0 ? normalize(d) : Vec3d{};
  }
  Vec3d sum{};
  double shared = 0;
  for (std::size_t i = 0, first = 0, last = 0; i < n; ++i) {
    while (last < n && time(last) <= time(i) + window / 2) sum = sum + direction[last++];
    while (time(first) < time(i) - window / 2) sum = sum - direction[first++];
    shared += length(sum) / double(last - first);
  }
  return n > 0 ? shared / double(n) : 0;
}

double share_far(const VoxelModel& moving, const Split& views, float far) {
  constexpr int kCells = 32;  // along the longest edge
  double shown = 0, beyond = 0;
  for (const SeenMotion& s : seen_motion(moving, views, {}, BitGrid(moving.box, kCells))) {
    shown += s.weight;
    if (length(s.offset) > far) beyond += s.weight;
  }
  return shown > 0 ? beyond / shown : 0;
}

}  // namespace splinevox
