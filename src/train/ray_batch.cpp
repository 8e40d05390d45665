// SPDX-License-Identifier: Apache-2.0
#include "train/ray_batch.hpp"

#include "math/photometric.hpp"

namespace splinevox {

RayBatch ray_batch(const Split& train, const Batch& batch, std::span<const Vec3> colours) {
  RayBatch out;
  out.colours.assign(colours.begin(), colours.end());
  for (std::size_t r = 0; r < batch.rays.size(); ++r) {
    const RayInput<float>& ray = batch.rays[r];
    const Patch& patch = batch.patches[r / 4];
    out.pixels.push_back({-1, -1, -1});
    if (patch.own_moment) {
      const PixelIndex at = *usable_pixel(train.frames[std::size_t(patch.frame)], patch.block, int(r % 4));
      out.pixels.back() = {patch.frame, at.x, at.y};
    }
    out.times.push_back(batch.times[std::size_t(batch.slot_of(int(r)))]);
    out.origins.push_back(ray.origin);
    out.directions.push_back(ray.direction);
    out.targets.push_back(colour_of(batch.targets[r]));
    out.backgrounds.push_back(ray.background);
    out.weights.push_back(ray.weight);
    out.photometric.push_back(photometric_gradient(colours[r], batch.targets[r], ray.weight));
  }
  return out;
}

}  // namespace splinevox
