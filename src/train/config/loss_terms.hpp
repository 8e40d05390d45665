// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/train/config_keys.hpp"

namespace splinevox {

/// What must be known of a loss term's weight, besides its value.
struct LossTerm {
  const char* key;  ///< of visit_config
  float LossConfig::*weight;
  int brightness;  ///< power of the scene's unit of brightness that the weight is multiplied by
  int edges;       ///< power of the box's longest edge that it is divided by, where it is given in edges
  bool guarded;    ///< its gradient has no bound but the weight: a large one can make every step unusable
  bool in_trials;  ///< whether the short fits that try effects out have it
};

/// Every weight of LossConfig. The photometric error is a square of colours, so each other term grows by the
/// square of the unit of brightness to keep its share; a factor inside a term does not. What rays give is
/// checked ray by ray and needs no guard. Fits have few control points, and priors on curves weigh more on
/// few points than on many.
inline constexpr LossTerm kLossTerms[] = {
    {"loss.tv_density", &LossConfig::tv_density, 2, 0, true, true},
    {"loss.tv_color", &LossConfig::tv_color, 2, 0, true, true},
    {"loss.tv_sh", &LossConfig::tv_sh, 2, 0, true, true},
    {"loss.tv_control", &LossConfig::tv_control, 2, 1, true, true},
    {"loss.tv_rigidity", &LossConfig::tv_rigidity, 2, 0, true, true},
    {"loss.tv_light", &LossConfig::tv_light, 2, 0, true, true},
    {"loss.tv_presence", &LossConfig::tv_presence, 2, 0, true, true},
    {"loss.still", &LossConfig::still, 2, 0, false, true},
    {"loss.transmittance", &LossConfig::transmittance, 2, 0, false, false},
    {"loss.depth", &LossConfig::depth, 2, 0, false, true},
    {"loss.tracks", &LossConfig::tracks, 2, 0, false, true},
    {"loss.offset", &LossConfig::offset, 2, 0, false, true},
    {"loss.offset_rigidity", &LossConfig::offset_rigidity, 0, 0, false, true},
    {"loss.divergence", &LossConfig::divergence, 2, 0, false, true},
    {"loss.curve_length", &LossConfig::curve_length, 2, 2, true, false},
    {"loss.curve_light", &LossConfig::curve_light, 2, 0, true, false},
    {"loss.curve_presence", &LossConfig::curve_presence, 2, 0, true, false},
    {"loss.curve_knots", &LossConfig::curve_knots, 2, 1, true, true},
    {"loss.curve_rest", &LossConfig::curve_rest, 2, 1, true, false},
};

/// The weights for a scene trained in a unit of brightness.
LossConfig in_unit_of_brightness(LossConfig loss, float unit);
/// The weights for lengths in scene units. @param edge  longest edge of the box, scene units
LossConfig in_scene_units(LossConfig loss, float edge);
/// The weights for the fits that try effects out.
LossConfig for_trials(LossConfig loss);
/// Whether guarded weights could make a gradient unusable on their own. @param loss  in scene units
bool can_spoil_gradients(const LossConfig& loss);

}  // namespace splinevox
