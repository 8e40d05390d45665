// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "io/vdb/vdb_cursor.hpp"

namespace splinevox {

/// What the grids of a file become in memory: all of them together.
struct VdbCost {
  std::uint64_t voxels = 0;       ///< in leaves, and those that active tiles stand for
  std::uint64_t tile_voxels = 0;  ///< the latter alone: a tile of a few bytes stands for up to 4096^3
  std::uint64_t bytes = 0;        ///< of OpenVDB's nodes, once tiles are leaves
  bool known = true;              ///< false: some grid's layout is not known here, and was not looked at
};

/// Adds voxels in leaves or tiles and what they take. Throws as soon as all of them pass the cursor's limits.
void add_cost(const Cursor& cursor, VdbCost& cost, std::uint64_t voxels, std::uint64_t bytes);

/// Goes over one grid from its compression flags to its last voxel without allocating what it says: every
/// mask, length, count and compressed block against the file and against what OpenVDB will make of it. Adds
/// to `cost` and throws as soon as that passes the limits.
/// @param type  the grid's as its descriptor says, "Tree_float_5_4_3_HalfFloat".
/// @param tree  false: an instance, which has none of its own.
/// @return false if the layout is not known; the cursor is then somewhere inside.
bool walk_grid(Cursor& cursor, std::string_view type, bool tree, VdbCost& cost);

/// A metadata table: count, then name, type and sized value of each entry. Sizes must be those of the types,
/// since OpenVDB reads as much as a type has. @return whether it says that floats are stored as halves.
bool walk_metadata(Cursor& cursor);

}  // namespace splinevox
