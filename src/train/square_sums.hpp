// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace splinevox {

/// How many squares of a map are set in any rectangle of it, after one pass (Crow 1984).
class SquareSums {
 public:
  /// @param set  whether square (x, y) is
  template <class Set>
  SquareSums(int width, int height, const Set& set)
      : columns_(std::size_t(width) + 1), sums_(columns_ * (std::size_t(height) + 1)) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sums_[index(x + 1, y + 1)] =
            at(x, y + 1) + at(x + 1, y) - at(x, y) + std::uint32_t(set(x, y) ? 1 : 0);
  }
  /// @pre 0 <= x0 <= x1 <= width, the same of y; x1 and y1 are not in it
  std::uint32_t in(int x0, int y0, int x1, int y1) const {
    return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
  }

 private:
  std::size_t index(int x, int y) const { return std::size_t(y) * columns_ + std::size_t(x); }
  std::uint32_t at(int x, int y) const { return sums_[index(x, y)]; }
  std::size_t columns_;
  std::vector<std::uint32_t> sums_;  ///< squares that are set above and to the left
};

}  // namespace splinevox
