// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/step.hpp"

namespace splinevox {

/// Gradient of a background's harmonics: the sum over the rays of the tasks, in their order, so the same bits
/// for any number of threads.
/// @param behind  [rays] gradient of the colour behind each
/// @param ranks   whose rays are added, each giving its own; null: nobody else's
BackgroundGradient background_gradient(const Background& background, std::span<const RayInput<float>> rays,
                                       std::span<const RayTask> tasks, std::span<const Vec3> behind,
                                       Ranks* ranks = nullptr);

}  // namespace splinevox
