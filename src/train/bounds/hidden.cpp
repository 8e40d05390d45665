// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/hidden.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "train/refine.hpp"

namespace splinevox {
namespace {

/// Rays per pixel of all training pictures from which on matter that none made visible is hidden: visible
/// matter is wider than a pixel and in more than one picture.
constexpr double kEnoughRays = 0.05;

bool enough_rays(const Split& train, std::int64_t rays) {
  double pixels = 0;
  for (const Frame& f : train.frames) pixels += double(f.camera.width) * f.camera.height;
  return double(rays) >= kEnoughRays * pixels;
}

}  // namespace

bool empty_hidden(const Setting& setting, const TimeWindow& window, Lattices& lattices) {
  const Visible& visible = lattices.visible;
  if (!window.whole) lattices.forget_visible(setting);  // rays of some times say nothing of the others
  if (!window.whole || !enough_rays(setting.train, visible.rays)) return false;
  Channels& raw = lattices.model.radiance.raw;
  Learner& learner = lattices.radiance;
  parallel_for(raw.topology->brick_count(), [&](int index) {
    const int brick = index + 1;
    for (int i = 0; i < kBrickRows; ++i) {
      if (visible.rows[brick].test(i)) continue;
      const std::size_t density = (std::size_t(brick) * kBrickRows + i) * raw.width;
      raw.values[density] = std::min(raw.values[density], kEmptyDensity);  // presence may be large
      learner.m[density] = learner.v[density] = 0;
    }
  });
  const bool dropped = prune_empty(raw, {&learner.m, &learner.v});
  if (dropped)
    for (AlignedVector<float>* rows : {&raw.values, &learner.m, &learner.v}) rows->shrink_to_fit();
  lattices.forget_visible(setting);
  return dropped;
}

}  // namespace splinevox
