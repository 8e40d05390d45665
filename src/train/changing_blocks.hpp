// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "train/silhouette_blocks.hpp"
#include "train/still/still_cameras.hpp"

namespace splinevox {

/// Blocks of 2 x 2 pixels near those in which a picture of a camera that stands still shows something else
/// than its still picture. Kept in the resolution of the camera's maps.
class ChangingBlocks {
 public:
  ChangingBlocks() = default;
  /// @param moment  which of the camera's frames
  ChangingBlocks(const Frame& frame, const StillCamera& camera, std::size_t moment);
  std::uint32_t count() const { return parts_ * parts_ * set_.count(); }
  /// The k-th of them, numbered as SilhouetteBlocks does. @pre k < count()
  std::uint32_t at(std::uint32_t k) const;

 private:
  int along_ = 0;            ///< blocks of 2 x 2 pixels in a row of the picture
  int factor_ = 1;           ///< pixels along a block of the map
  int width_ = 0;            ///< of the map
  std::uint32_t parts_ = 1;  ///< blocks of 2 x 2 pixels along one of the map
  BlockSet set_;             ///< of the map
};

}  // namespace splinevox
