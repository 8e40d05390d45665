// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// How far pictures of about the same time see the scene from the same side: the length of the mean of their directions, on the mean over the pictures. 1: a film,
/// whose camera hardly moves meanwhile; towards 0: cameras all around.
/// @param middle  of the scene. @param window  of time, in which times are about the same
double shared_direction(const Split& train, const Vec3& middle, double window);

/// Share of what views show that a moving model displaces by more than `far` scene units.
double share_far(const VoxelModel& moving, const Split& views, float far);

}  // namespace splinevox
