// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace splinevox {

/// The nearest standard deviation that an .spz can hold: its logarithm is kept in sixteenths from -10 on.
inline double spz_scale(double size) {
  return std::exp(std::clamp(std::round((std::log(size) + 10) * 16), 0.0, 255.0) / 16 - 10);
}

/// Whether it can hold a size, to half a sixteenth of its logarithm.
inline bool spz_has(double size) {
  constexpr double kRounding = 0.033;
  return std::abs(spz_scale(size) / size - 1) < kRounding;
}

}  // namespace splinevox
