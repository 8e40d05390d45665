// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/train/config.hpp"

namespace splinevox {

/// A preset with the effects that `train` finds in a scene of solid matter before cameras that see alike.
/// Kept untried (EffectPolicy::keep), the others would be learned as well.
inline Config solid_preset(const std::string& name) {
  Config c = preset(name);
  c.motion.presence = c.cameras.exposure = c.cameras.drift = c.cameras.clock = false;
  return c;
}

}  // namespace splinevox
