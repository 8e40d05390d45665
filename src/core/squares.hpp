// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace splinevox {

/// Pixels along a block, so that at most `longest` blocks lie along a picture. A very elongated one has more:
/// a block is no larger than its shorter side.
inline int block_factor(int width, int height, int longest) {
  const int most = std::max(1, std::min(width, height));
  return std::clamp((std::max(width, height) + longest - 1) / longest, 1, most);
}

/// Pixels along a square of a CoarseMask of what moves: at most 200 squares lie along a picture.
inline int squares_factor(int width, int height) {
  constexpr int kMostSquares = 200;
  return block_factor(width, height, kMostSquares);
}

}  // namespace splinevox
