// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox {

/// Below this angle between its views, degrees, the depth of a static scene is not determined.
constexpr double kLeastParallax = 1;

/// Whether the silhouettes of the train split meet where its cameras look. If they do not, and would with
/// cameras written in another way, throws Error (Fault::input) naming that way; else says that they do not.
/// @param note  hears it
/// @param known  explained_by_hull of the split's own cameras, if it was computed before
void check_silhouettes(const Split& train, const std::function<void(std::string)>& note,
                       std::optional<double> known = {});

/// The largest angle between two views of the scene, degrees; says so where it is below kLeastParallax.
/// @param config  whose box the scene lies in, if it has one
double check_parallax(const Config& config, const Split& train, const std::function<void(std::string)>& note);

/// Whether any trial fit shows held-out pictures better than one colour per picture would.
void note_bad_fits(const Split& train, const EffectChoice& effects,
                   const std::function<void(std::string)>& note);

}  // namespace splinevox
