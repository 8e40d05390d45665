// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/occupancy.hpp"
#include "train/still/still_cameras.hpp"

namespace splinevox {

/// Cells of observed space, 32 along the longest edge of the box, in which something may change over time.
///
/// What moves in a cell changes the pixels of every camera before which nothing static hides it. So a cell
/// may change if two cameras see a change there at some moment. It is static if two others see none, and half
/// of all that see it, because static matter may hide it from some. A camera's change that no such cell
/// explains may be anywhere along its ray. Cells beside one that may change may change too: things move on
/// between two moments.
///
/// Cameras vote that see nearly every moment of the split, in steady light. Where fewer than two do, nothing
/// is known, and no cells are returned.
/// Whether enough of these cameras vote.
bool tell_cells(const std::vector<StillCamera>& cameras, const Split& split);
BitGrid changing_cells(const std::vector<StillCamera>& cameras, const Split& split, const Box& box);

}  // namespace splinevox
