// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/field/model.hpp"

namespace splinevox {

/// In words, what changes over time in a model in which nothing moves, for messages: "only its light
/// changes".
/// "" where nothing changes at all, or where matter moves.
inline std::string what_changes(const MotionField& motion) {
  if (motion.levels.empty() || motion.displaces) return "";
  if (!motion.presence) return "only its light changes";
  return motion.light ? "only its light changes, and matter comes and goes" : "matter only comes and goes";
}

}  // namespace splinevox
