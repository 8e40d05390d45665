// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Which blocks of a picture something is true of, row by row.
using BlockMap = std::vector<std::uint8_t>;
double share_of(const BlockMap& map);

/// A camera that stands still, and what its own pixels prove without any fit: where a picture differs from
/// the camera's still picture, the median over its moments.
///
/// A block differs by more than the noise of its picture: of the sensor, of compression, of a camera that
/// shakes by a part of a pixel, of an exposure that flickers. All of these are measured on the picture
/// itself, by what most of it has in common.
struct StillCamera {
  std::vector<int> frames;             ///< of the split, in order of time
  int factor = 1;                      ///< pixels along a block of the maps
  int width = 0, height = 0;           ///< blocks
  std::vector<std::vector<bool>> now;  ///< [frames]: the block differs at this moment
  BlockMap ever;                       ///< at some moment
  BlockMap unknown;                    ///< its noise may hide a change
  double share = 0;                    ///< of the blocks that ever differ
  double most = 0;                     ///< of the blocks that differ at one moment
  double flicker = 0;                  ///< largest change of the whole picture's brightness, a share of it

  /// Index of a block into a map.
  std::size_t block(int x, int y) const { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
  /// No change of the light of everything, which would be taken for one of the exposure.
  bool steady() const { return flicker < 0.03; }
  /// What differs at a moment.
  CoarseMask changing(std::size_t moment) const;
};

/// The cameras of a split that stand still and have three moments or more: frames of one camera_id, of one
/// pose and lens. None where the data knows no cameras. A camera most of whose picture differs at one moment
/// has moved, or its light has: it is left out too.
/// @param unit  of brightness, in (0, 1]: that of a dark scene, whose noise is as much smaller
std::vector<StillCamera> still_cameras(const Split& split, float unit = 1);

}  // namespace splinevox
