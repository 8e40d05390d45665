// SPDX-License-Identifier: Apache-2.0
#include "backend/background_gradient.hpp"

#include "core/parallel.hpp"
#include "math/background_color.hpp"

namespace splinevox {

BackgroundGradient background_gradient(const Background& background, std::span<const RayInput<float>> rays,
                                       std::span<const RayTask> tasks, std::span<const Vec3> behind,
                                       Ranks* ranks) {
  std::vector<BackgroundGradient> parts(tasks.size());
  parallel_for(int(parts.size()), [&](int t) {
    for (int i = tasks[t].first; i < tasks[t].last; ++i) {
      const Vec3& d = rays[i].direction;
      background_color_vjp(background.order, d, background_color(background.order, background.raw, d).slope,
                           behind[i], parts[t].data());
    }
  });
  BackgroundGradient sum{};
  for (const BackgroundGradient& part : parts)
    for (int j = 0; j < background.count(); ++j) sum[j] += part[j];
  if (ranks) sum_over_ranks(*ranks, {&sum[0].x, 3 * sum.size()});
  return sum;
}

}  // namespace splinevox
