// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "splinevox/data/scene.hpp"
#include "train/silhouette_blocks.hpp"

namespace splinevox {

/// Blocks of 2 x 2 pixels near those in which a picture shows something that moves. Kept in the squares of
/// its mask.
class ChangingBlocks {
 public:
  ChangingBlocks() = default;
  /// @param moving  of the frame; empty: nothing is known
  ChangingBlocks(const Frame& frame, const CoarseMask& moving);
  bool known() const { return width_ > 0; }
  std::uint32_t count() const { return parts_ * parts_ * set_.count(); }
  /// The k-th of them, numbered as SilhouetteBlocks does. @pre k < count()
  std::uint32_t at(std::uint32_t k) const;
  /// How often a block, numbered as SilhouetteBlocks does, is among them: a block may lie in several squares.
  std::uint32_t times(std::uint32_t block) const;
  /// Whether a pixel is in one of them.
  bool near(int x, int y) const {
    return set_.test(std::min(x / factor_, width_ - 1), std::min(y / factor_, height_ - 1));
  }

 private:
  int along_ = 0;               ///< blocks of 2 x 2 pixels in a row of the picture
  int factor_ = 1;              ///< pixels along a square
  int width_ = 0, height_ = 0;  ///< squares
  std::uint32_t parts_ = 1;     ///< blocks of 2 x 2 pixels along a square
  BlockSet set_;                ///< of the squares
};

}  // namespace splinevox
