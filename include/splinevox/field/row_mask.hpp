// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "splinevox/field/topology.hpp"

namespace splinevox {

/// One bit per row of a brick: which rows got a gradient. Rows without are left alone by the optimiser, so rounding does not
/// move what no ray has seen (numerics 0.8).
struct RowMask {
  std::uint64_t word[kBrick] = {};  ///< word x, bit y * 8 + z
  bool any() const {
    std::uint64_t all = 0;
    for (const std::uint64_t w : word) all |= w;
    return all != 0;
  }
  void set(int row) { word[row >> 6] |= std::uint64_t(1) << (row & 63); }
  void set_all() {
    for (std::uint64_t& w : word) w = ~std::uint64_t(0);
  }
};

}  // namespace splinevox
