// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "splinevox/core/vec3.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// How far a channel of the ground may be off its colour: what JPEG and a camera's noise do to it.
constexpr float kGroundTolerance = 6.5f / 255;

/// The colour of a plain ground behind opaque pictures: one colour along three quarters of the border of most
/// of them. None if there is no such colour.
std::optional<Vec3> find_ground(const Split& train);

/// Gives pixels that show nothing but the ground alpha 0: those of its colour that hang together with the
/// picture's border, a ring of two pixels around everything else left out, which mixes both.
/// @return the share of all pixels.
double cut_ground(Split& train, const Vec3& colour);

/// Makes every pixel opaque again.
void undo_cut(Split& train);

}  // namespace splinevox
