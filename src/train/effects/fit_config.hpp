// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/train/effects.hpp"

namespace splinevox {

/// The configuration of a fit with some effects: coarse lattices, few rays, the weights as they are.
Config fit_config(const Config& config, const EffectSet& effects);

}  // namespace splinevox
