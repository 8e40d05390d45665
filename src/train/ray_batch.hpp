// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/colour_loss.hpp"
#include "train/batch.hpp"

namespace splinevox {

/// A batch as a ColourLoss sees it. @param colours  [rays] that the model has
RayBatch ray_batch(const Split& train, const Batch& batch, std::span<const Vec3> colours);

}  // namespace splinevox
