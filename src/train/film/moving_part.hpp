// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/occupancy.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Cells of observed space, 64 along the longest edge of the box, in which something may move, by what the
/// pictures of a film show that moves.
///
/// A cell is free if a few pictures in a row all show motion before it: in between, the camera has moved on,
/// and what is not there has left the line of sight. Motion that no such cell explains may be anywhere along
/// its ray where the picture before or after shows some as well. Cells beside free ones are free: things move
/// on between two pictures.
/// @param moving  of each frame
/// @return no cells where nothing is known of some frame
BitGrid cells_that_move(const std::vector<CoarseMask>& moving, const Split& split, const Box& box);

}  // namespace splinevox
