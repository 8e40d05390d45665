// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "splinevox/field/channels.hpp"
#include "splinevox/field/row_mask.hpp"

namespace splinevox {

/// Which rows of the motion are read and learned. All others are at rest: they are zero, and stay it.
struct ActiveRows {
  std::vector<RowMask> rows;   ///< [bricks + 1]; the background's are always active, and zero
  std::vector<RowMask> cells;  ///< [bricks + 1] by first corner: cells with an active corner, which samples must look into; empty: all cells

  /// A bit per row, as FieldView has it; null: all cells.
  const std::uint64_t* cell_bits() const { return cells.empty() ? nullptr : cells[0].word; }
};

/// The cells of a set of rows. One whose first corner is absent is among them if any such cell at its place in a brick is.
std::vector<RowMask> cells_of_rows(const Topology& topology, const std::vector<RowMask>& rows);

/// The rows of a level that are not zero, and their cells if fewer than half of all cells have any.
ActiveRows nonzero_rows(const Channels& level);

}  // namespace splinevox
