// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// One bit per row of a brick. Of the rows that got a gradient: rows without are left alone by the optimiser,
/// so rounding does not move what no ray has sampled.
struct RowMask {
  std::uint64_t word[kBrick] = {};  ///< word x, bit y * 8 + z
  bool any() const {
    std::uint64_t all = 0;
    for (const std::uint64_t w : word) all |= w;
    return all != 0;
  }
  void set(int row) { word[row >> 6] |= std::uint64_t(1) << (row & 63); }
  RowMask& operator|=(const RowMask& other) {
    for (int x = 0; x < kBrick; ++x) word[x] |= other.word[x];
    return *this;
  }
  RowMask& operator&=(const RowMask& other) {
    for (int x = 0; x < kBrick; ++x) word[x] &= other.word[x];
    return *this;
  }
  RowMask operator~() const {
    RowMask out;
    for (int x = 0; x < kBrick; ++x) out.word[x] = ~word[x];
    return out;
  }
  friend bool operator==(const RowMask&, const RowMask&) = default;
  bool test(int row) const { return word[row >> 6] >> (row & 63) & 1; }
  /// Calls visit(row) for every set row, in order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (int x = 0; x < kBrick; ++x)
      for (std::uint64_t bits = word[x]; bits; bits &= bits - 1) visit(x * 64 + std::countr_zero(bits));
  }
  static RowMask all() {
    RowMask mask;
    mask.set_all();
    return mask;
  }
  void set_all() {
    for (std::uint64_t& w : word) w = ~std::uint64_t(0);
  }
};

}  // namespace splinevox
