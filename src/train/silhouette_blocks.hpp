// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// A bit per block of a picture, row by row, and how many are set before each row.
struct BlockSet {
  int words = 0;  ///< of a row
  std::vector<std::uint64_t> bits;
  std::vector<std::uint32_t> starts;  ///< the last is the number of all
  BlockSet() = default;
  BlockSet(int width, int height)
      : words((width + 63) / 64), bits(std::size_t(words) * std::size_t(height)) {}
  void set(int x, int y) { bits[std::size_t(y) * words + x / 64] |= std::uint64_t(1) << (x % 64); }
  bool test(int x, int y) const { return bits[std::size_t(y) * words + x / 64] >> (x % 64) & 1; }
  void number();  ///< once all are set
  std::uint32_t count() const { return starts.empty() ? 0 : starts.back(); }
  /// The k-th block that is set. @pre k < count()
  std::uint32_t at(std::uint32_t k, int width) const;
};

/// In which blocks of 2 x 2 pixels a picture shows something (alpha above 0), which lie near those, and which
/// are of ignored pixels alone. Blocks are numbered row by row; at an odd edge a block repeats its last
/// pixels. Kept as bits, and not at all of opaque pictures without ignored pixels: there may be thousands.
class SilhouetteBlocks {
 public:
  SilhouetteBlocks() = default;
  /// @param ring  blocks around those that show something, or are ignored in part, which count as near, along
  /// the longer axis
  SilhouetteBlocks(const Frame& frame, int ring);
  /// Usable blocks near what is shown, and the k-th of them.
  /// @{
  std::uint32_t near_count() const { return all_ ? blocks() : near_.count(); }
  std::uint32_t near(std::uint32_t k) const { return all_ ? k : near_.at(k, width_); }
  /// @}
  /// Whether a block is among the near ones.
  bool is_near(std::uint32_t block) const {
    return all_ || near_.test(int(block % std::uint32_t(width_)), int(block / std::uint32_t(width_)));
  }
  /// Blocks of which some pixel is not ignored, and the k-th of them.
  /// @{
  std::uint32_t usable_count() const { return usable_.bits.empty() ? blocks() : usable_.count(); }
  std::uint32_t usable(std::uint32_t k) const { return usable_.bits.empty() ? k : usable_.at(k, width_); }
  /// @}
  /// Whether nothing is shown or ignored within so many blocks of one, along the longer axis; never beyond
  /// 254.
  bool clear(std::uint32_t block, double blocks) const;

 private:
  std::uint32_t blocks() const { return std::uint32_t(width_) * std::uint32_t(height_); }
  int width_ = 0, height_ = 0;      ///< blocks
  bool all_ = true;                 ///< every block is shown and usable, and none has a bit
  BlockSet shown_, near_, usable_;  ///< usable_: empty where nothing is ignored
};

}  // namespace splinevox
