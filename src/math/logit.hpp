// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace splinevox {

/// The raw value whose sigmoid is p. @param p  in (0, 1): clamp what may reach an end, which is infinite here
inline float logit(float p) { return std::log(p / (1 - p)); }

}  // namespace splinevox
