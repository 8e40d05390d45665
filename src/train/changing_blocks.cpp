// SPDX-License-Identifier: Apache-2.0
#include "train/changing_blocks.hpp"

#include <algorithm>

#include "train/patch.hpp"

namespace splinevox {
namespace {

constexpr int kMovingRing = 4;  ///< pixels around what changes

bool any_ignored(const PixelMask& ignored, int x0, int y0, int size) {
  for (int y = y0; y < y0 + size && !ignored.empty(); ++y)
    for (int x = x0; x < x0 + size; ++x)
      if (ignored.test(x, y)) return true;
  return false;
}

}  // namespace

ChangingBlocks::ChangingBlocks(const Frame& frame, const CoarseMask& moving)
    : along_(blocks_along(frame.image.width)),
      factor_(moving.factor),
      width_(moving.squares.width()),
      height_(moving.squares.height()),
      parts_(std::uint32_t(moving.factor + 1) / 2),
      set_(width_, height_) {
  const int ring = (kMovingRing + factor_ - 1) / factor_;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      if (!moving.squares.test(x, y)) continue;
      for (int v = std::max(0, y - ring); v <= std::min(height_ - 1, y + ring); ++v)
        for (int u = std::max(0, x - ring); u <= std::min(width_ - 1, x + ring); ++u)
          if (!any_ignored(frame.ignored, u * factor_, v * factor_, factor_)) set_.set(u, v);
    }
  set_.number();
}

std::uint32_t ChangingBlocks::at(std::uint32_t k) const {
  const std::uint32_t part = k % (parts_ * parts_), block = set_.at(k / (parts_ * parts_), width_);
  const auto along = [&](std::uint32_t of_map, std::uint32_t p) {
    return of_map * std::uint32_t(factor_) / 2 + p;
  };
  return along(block / std::uint32_t(width_), part / parts_) * std::uint32_t(along_) +
         along(block % std::uint32_t(width_), part % parts_);
}

std::uint32_t ChangingBlocks::times(std::uint32_t block) const {
  const int x = 2 * int(block % std::uint32_t(along_)), y = 2 * int(block / std::uint32_t(along_));
  std::uint32_t count = 0;
  for (int v = y / factor_; v <= std::min((y + 1) / factor_, height_ - 1); ++v)
    for (int u = x / factor_; u <= std::min((x + 1) / factor_, width_ - 1); ++u) count += set_.test(u, v);
  return count;
}

}  // namespace splinevox
