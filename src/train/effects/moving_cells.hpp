// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/occupancy.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/cameras.hpp"

namespace splinevox {

/// Cells of observed space, 32 along the longest edge of the box, in which motion explains what a static
/// model cannot.
///
/// The colour error of a ray is given to the cells where the moving model has its matter, which is where
/// things truly are at that time. What a cell is given at one time is averaged before anything is squared, so
/// that edges and texture, which are too soft in a short fit, average out; the error of a motion does not. A
/// cell is one if the variance over time of these means falls by more than `least` squared from the static
/// model to the moving one, in it and on the mean of it and the six beside it: one cell alone may be chance.
/// @param moving, still  short fits to the same pictures, with motion and without
/// @param least          [0, 1], black to white
/// @param cameras        what the moving fit knows of them
BitGrid moving_cells(const VoxelModel& moving, const VoxelModel& still, const Split& views, float least,
                     const CameraFits& cameras = {});

/// 1 where most of what a pixel shows lies in the cells, else 0, as where it is ignored; [height, width, 1].
Image shows_cells(const VoxelModel& moving, const BitGrid& cells, const Frame& frame);

}  // namespace splinevox
