// SPDX-License-Identifier: Apache-2.0
#include "train/silhouette_blocks.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "train/patch.hpp"

namespace splinevox {
namespace {

constexpr int kWord = 64;
constexpr double kFurthest = 255;  ///< blocks; further is not asked for

/// A row and its neighbours on both sides.
void grow_row(std::uint64_t* row, int words, std::uint64_t last) {
  std::uint64_t before = 0;
  for (int i = 0; i < words; ++i) {
    const std::uint64_t here = row[i], after = i + 1 < words ? row[i + 1] : 0;
    row[i] = here | here << 1 | here >> 1 | before >> (kWord - 1) | after << (kWord - 1);
    before = here;
  }
  row[words - 1] &= last;
}

}  // namespace

void BlockSet::number() {
  starts.assign(1, 0);
  for (std::size_t i = 0; i < bits.size(); i += std::size_t(words)) {
    std::uint32_t count = starts.back();
    for (int k = 0; k < words; ++k) count += std::uint32_t(std::popcount(bits[i + std::size_t(k)]));
    starts.push_back(count);
  }
}

std::uint32_t BlockSet::at(std::uint32_t k, int width) const {
  const std::size_t y = std::size_t(std::upper_bound(starts.begin(), starts.end(), k) - starts.begin()) - 1;
  std::uint32_t left = k - starts[y];
  const std::uint64_t *const first = bits.data() + y * std::size_t(words), *word = first;
  for (; left >= std::uint32_t(std::popcount(*word)); ++word) left -= std::uint32_t(std::popcount(*word));
  std::uint64_t rest = *word;
  for (; left > 0; --left) rest &= rest - 1;  // without its lowest bit
  return std::uint32_t(y) * std::uint32_t(width) +
         std::uint32_t((word - first) * kWord + std::countr_zero(rest));
}

SilhouetteBlocks::SilhouetteBlocks(const Frame& frame, int ring)
    : width_(blocks_along(frame.image.width)),
      height_(blocks_along(frame.image.height)),
      all_(frame.image.opaque() && frame.ignored.empty()) {
  if (all_) return;
  const Picture& picture = frame.image;
  shown_ = BlockSet(width_, height_);
  if (!frame.ignored.empty()) usable_ = BlockSet(width_, height_);
  {
    const ReadAll all_of(picture);
    std::size_t i = 0;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x, ++i) {
        const bool ignored = frame.ignored.test(i);
        if (ignored || picture.pixel(i)[3] > 0) shown_.set(x / 2, y / 2);
        if (!ignored && !usable_.bits.empty()) usable_.set(x / 2, y / 2);
      }
  }
  usable_.number();
  std::vector<std::uint64_t> wide = shown_.bits;
  const int words = shown_.words;
  const std::uint64_t last = ~std::uint64_t(0) >> (words * kWord - width_);
  for (int y = 0; y < height_; ++y)
    for (int k = 0; k < ring; ++k) grow_row(wide.data() + std::size_t(y) * words, words, last);
  near_ = BlockSet(width_, height_);
  for (int y = 0; y < height_; ++y)
    for (int i = 0; i < words; ++i) {
      const std::size_t at = std::size_t(y) * words + i;
      for (int v = std::max(0, y - ring); v <= std::min(height_ - 1, y + ring); ++v)
        near_.bits[at] |= wide[std::size_t(v) * words + i];
      if (!usable_.bits.empty()) near_.bits[at] &= usable_.bits[at];
    }
  near_.number();
}

bool SilhouetteBlocks::clear(std::uint32_t block, double blocks) const {
  if (all_ || !(blocks < kFurthest)) return false;
  const int reach = int(blocks), x = int(block % std::uint32_t(width_)),
            y = int(block / std::uint32_t(width_));
  const int left = std::max(0, x - reach), right = std::min(width_ - 1, x + reach);
  for (int v = std::max(0, y - reach); v <= std::min(height_ - 1, y + reach); ++v)
    for (int i = left / kWord; i <= right / kWord; ++i) {
      std::uint64_t word = shown_.bits[std::size_t(v) * shown_.words + i];
      if (i == left / kWord) word &= ~std::uint64_t(0) << (left % kWord);
      if (i == right / kWord) word &= ~std::uint64_t(0) >> (kWord - 1 - right % kWord);
      if (word) return false;
    }
  return true;
}

}  // namespace splinevox
