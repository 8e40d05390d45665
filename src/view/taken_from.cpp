// SPDX-License-Identifier: Apache-2.0
#include "view/taken_from.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace splinevox::run {

std::optional<TakenFrom> taken_from(const TrainingCameras& train) {
  if (train.stand == Stand::around) return {};
  constexpr std::size_t kMost = 96;
  TakenFrom out{train.middle, {}, std::numeric_limits<double>::infinity(), 0, 0};
  const std::size_t n = train.places.size(), count = std::min(n, kMost);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d from = train.places[i * n / count].camera.position - train.middle;
    const double distance = std::max(length(from), 1e-9);
    out.directions.push_back(from * (1 / distance));
    out.near = std::min(out.near, distance);
    out.far = std::max(out.far, distance);
  }
  for (std::size_t i = 0; i < count; ++i) {
    double least = std::numbers::pi;
    for (std::size_t j = 0; j < count; ++j)
      if (j != i) least = std::min(least, angle_between(out.directions[i], out.directions[j]));
    if (count > 1) out.spacing = std::max(out.spacing, least);
  }
  return out;
}

}  // namespace splinevox::run
