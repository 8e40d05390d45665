// SPDX-License-Identifier: Apache-2.0
#include "run/true_shots.hpp"

#include <algorithm>

#include "core/squares.hpp"
#include "splinevox/data/image_io.hpp"
#include "train/by_time.hpp"

namespace splinevox::run {

namespace {

bool is_clear(const Image& rgba) {
  for (std::size_t i = 3; i < rgba.data.size(); i += 4)
    if (rgba.data[i] < 1) return true;
  return false;
}

}  // namespace

TrueShot true_shot(const Frame& f, const std::optional<Vec3>& background, int size) {
  const int factor = block_factor(f.image.width, f.image.height, size);
  const Picture small = area_downscale(f.image, factor);
  const Image rgba = small.as_floats();
  const bool clear = !background && is_clear(rgba);
  return {f.name, area_downscale(f.camera, factor), std::clamp(f.time, 0.0, 1.0),
          encode_png(clear ? rgba : composite(small, background.value_or(Vec3{}))), clear};
}

std::vector<TrueShot> true_shots(const Split& split, const std::optional<Vec3>& background, int count,
                                 int size) {
  const std::vector<int> order = frames_by_time(split);
  const std::size_t n = order.size(), taken = std::min(n, std::size_t(count));
  std::vector<TrueShot> shots;
  for (std::size_t k = 0; k < taken; ++k) {
    const int at = order[taken > 1 ? k * (n - 1) / (taken - 1) : n / 2];
    shots.push_back(true_shot(split.frames[std::size_t(at)], background, size));
  }
  return shots;
}

}  // namespace splinevox::run
