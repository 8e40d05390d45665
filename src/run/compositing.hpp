// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/image.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/run/cameras.hpp"

/// Renders as compositing programs take them.
namespace splinevox::run {

/// Depth of what is empty.
inline constexpr float kEmptyDepth = 1e10f;

/// What is seen without what is behind it: display values, not times alpha, and alpha. 4 channels; all 0
/// where nothing is seen. @pre one ray a pixel, or one colour behind them all
Image without_background(const VoxelModel& model, const Rendered& r, const Camera& camera);

/// The model with nothing behind it: its pictures are display values times alpha, however many rays a pixel
/// has.
VoxelModel nothing_behind(const VoxelModel& model);

/// A picture of such a model as scene-linear light times alpha: divided by alpha, decoded by sRGB's curve and
/// multiplied again. 4 channels.
Image premultiplied(const Rendered& r);

/// Distance along the viewing axis, scene units; kEmptyDepth where nothing is seen. 1 channel.
Image depth_layer(const Rendered& r);

/// Where what a pixel sees is on the picture of another shot, less where it is now: pixels to the right and
/// upwards. The matter at the pixel's depth is carried to the other time (track), and both cameras count. 0
/// where less than a twentieth is seen, or where the way of the matter is not known. 2 channels.
Image motion_vectors(const VoxelModel& model, const Rendered& r, const Shot& shot, const Shot& other);

}  // namespace splinevox::run
