// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/step.hpp"
#include "splinevox/field/model.hpp"
#include "train/start.hpp"

namespace splinevox {

/// Moments of a learned background's harmonics.
struct BackgroundLearner {
  Vec3 m[kMaxShCount] = {}, v[kMaxShCount] = {};
};

/// Whether a colour is learned behind these pictures: the configuration wants one and they are opaque.
/// Pictures with alpha say that there is nothing behind.
bool learns_background(const Config& config, const PictureStats& stats);

/// One colour before training, that along the borders of the pictures: what is there is more often behind
/// than what is in the middle. @param unit  of brightness (train/start.hpp)
Background starting_background(const Config& config, const Split& train, const PictureStats& stats,
                               float unit);

/// One step on the harmonics; `color` follows their band 0.
void update(Background& background, BackgroundLearner& learner, const BackgroundGradient& gradient,
            const MomentFactors& factors, float rate);

}  // namespace splinevox
