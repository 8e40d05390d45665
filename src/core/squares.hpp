// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace splinevox {

/// Pixels along a square of a CoarseMask of what moves: at most 200 squares lie along a picture.
inline int squares_factor(int width, int height) {
  constexpr int kMostSquares = 200;
  return std::max(1, (std::max(width, height) + kMostSquares - 1) / kMostSquares);
}

}  // namespace splinevox
