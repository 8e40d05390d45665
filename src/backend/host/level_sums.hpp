// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "field/lattice/levels.hpp"

namespace splinevox {

/// The sum of motion levels on the finest one's lattice. Keeps its arrays from call to call: every step makes
/// the sum, and fresh memory would cost more than the additions.
class LevelSums {
 public:
  /// @param levels  coarse to fine, at least one. @param rows  of the finest level that are wanted, [bricks +
  /// 1]; the others keep what they had, at first zeros. empty: all rows
  /// @return the sum: with one level, that level
  const Channels& make(std::span<const Channels* const> levels, std::span<const RowMask> rows);
  /// What `make` returned.
  const Channels& sum() const { return *sum_; }

 private:
  std::vector<Channels> sums_;  ///< of the levels up to each but the first
  const Channels* sum_ = nullptr;
};

}  // namespace splinevox
