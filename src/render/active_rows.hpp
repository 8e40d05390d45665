// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "field/lattice/row_mask.hpp"
#include "render/occupancy.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Which rows of the motion are read and learned. All others are frozen: they are zero and stay zero.
struct ActiveRows {
  std::vector<RowMask> rows;  ///< [bricks + 1]; the background's are always active, and zero
  BitGrid reach;  ///< where samples may read one that can be other than zero, with the cells of every frame's
                  ///< occupancy; no cells: everywhere
};

/// How far along an axis a sample may be from a vertex that it reads, scene units.
float reach_of_vertex(const Lattice& lattice);
/// The same without the allowance for rounding, and a ten thousandth shorter. Cells that share their faces
/// with the lattice's then do not touch their neighbours. A cell that ends within that much of a vertex'
/// reach misses a ten thousandth of its value.
float extent_of_vertex(const Lattice& lattice);
/// The cells of a grid like `like` in which a sample may read one of a set of rows.
BitGrid reach_of(const Topology& topology, const std::vector<RowMask>& rows, const BitGrid& like);

/// The rows of a level that are not zero, [bricks + 1].
std::vector<RowMask> nonzero_rows(const Channels& level);

}  // namespace splinevox
