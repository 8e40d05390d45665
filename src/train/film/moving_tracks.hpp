// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Whether a tracked point says anything of a frame: not where the frame's pixels are ignored.
/// @pre  the point lies in the picture
inline bool counts(const Frame& frame, const VisiblePoint& p) {
  return !frame.ignored.test(int(p.u), int(p.v));
}

/// Which tracked points move: those that no place explains that stands still. The place nearest to all rays
/// through a point misses it in a quarter of its pictures or more, by a hundredth of the picture or three
/// times what most points are missed by. Three sightings say nothing.
/// @return [points]
std::vector<char> points_that_move(const Split& train);

/// Squares of a frame around such points. One whose nearest four do not move for the most part is a track
/// that went wrong.
/// @param moves  as points_that_move gives it. @param factor  pixels along a square
PixelMask squares_of_moving(const Frame& frame, const std::vector<char>& moves, int factor);

}  // namespace splinevox
