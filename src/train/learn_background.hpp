// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "math/adam.hpp"
#include "splinevox/math/background.hpp"
#include "train/batch.hpp"
#include "train/start.hpp"

namespace splinevox {

/// Moments of a learned background's harmonics.
struct BackgroundLearner {
  Vec3 m[kMaxShCount] = {}, v[kMaxShCount] = {};
};

/// Whether a colour is learned behind these pictures: the configuration wants one and they are opaque.
/// Pictures with alpha say that there is nothing behind.
bool learns_background(const Config& config, const Shown& shown);

/// One colour before training, that along the borders of the pictures: what is there is more often behind
/// than what is in the middle.
Background starting_background(const Config& config, const Split& train, const Shown& shown);

/// Gradient of the harmonics: the sum over the rays of a batch's tasks, in their order, so the same bits for
/// any number of threads.
using BackgroundGradient = std::array<Vec3d, kMaxShCount>;
BackgroundGradient background_gradient(const Background& background, const Batch& batch,
                                       std::span<const Vec3> behind);

/// One step on the harmonics; `color` follows their band 0.
void update(Background& background, BackgroundLearner& learner, const BackgroundGradient& gradient,
            const MomentFactors& factors, float rate);

}  // namespace splinevox
