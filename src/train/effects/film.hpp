// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// How much of where pictures see the scene from the time tells, 0..1: one less the spread of their
/// directions among pictures of about the same time, as a share of the spread among all (means of 1 - cos
/// over pairs of pictures). Near 1 of a film, whose camera passes by; near 0 of cameras that are anywhere at
/// any time, of a rig that sees every time, and of a camera that stands.
/// @param middle  of the scene. @param window  in which times are about the same; pictures of neighbouring
/// times always are
double view_told_by_time(const Split& train, const Vec3& middle, double window);

/// Share of what views show, in cells of a 32nd of the box, that a moving model displaces by more than `far`
/// scene units, on the mean over time.
double share_far(const VoxelModel& moving, const Split& views, float far);

}  // namespace splinevox
