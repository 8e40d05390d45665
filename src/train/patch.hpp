// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>

namespace splinevox {

/// A block of 2 x 2 pixels of a training picture: the patch that four rays go through. Blocks are numbered
/// row by row; at an odd edge a block repeats its last pixels.
struct Patch {
  int frame;
  std::uint32_t block;
  bool own_moment = true;  ///< false: the slot that it is drawn for is of another moment than its picture
  friend auto operator<=>(const Patch&, const Patch&) = default;
};

/// Blocks along an edge of a picture.
inline int blocks_along(int pixels) { return (pixels + 1) / 2; }

}  // namespace splinevox
