// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// How well the time of a picture tells its viewing direction, 0..1.
///
///   1 - (spread of directions among pictures of about the same time) / (spread among all pictures)
///
/// A spread is the mean of 1 - cos over pairs of pictures. The result is near 1 for a video whose camera
/// moves. It is near 0 for cameras that are anywhere at any time, for a rig that sees every time, and for a
/// camera that does not move.
/// @param middle  of the scene, scene units
/// @param window  within which times count as the same; pictures of neighbouring times always do
double view_told_by_time(const Split& train, const Vec3& middle, double window);

/// Whether that makes a film of pictures: of one camera on its way.
inline bool is_film(double told) { return told > 0.8; }

/// Share of the visible cells, of 32 along the box, that a moving model displaces by more than `far` scene
/// units on the mean over time.
double share_far(const VoxelModel& moving, const Split& views, float far);

}  // namespace splinevox
