// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Regular grid of cells over a box, x slowest.
struct CellGrid {
  Vec3 origin{};
  float cell = 1;  ///< scene units
  Int3 size{};

  CellGrid() = default;
  CellGrid(const Box& box, int cells_along_longest);
  std::size_t cells() const { return std::size_t(size.x) * size.y * size.z; }
  std::size_t index(Int3 c) const { return (std::size_t(c.x) * size.y + c.y) * size.z + c.z; }
  Int3 cell_at(std::size_t index) const {
    return {int(index / size.z / size.y), int(index / size.z % size.y), int(index % size.z)};
  }
  Vec3 center(Int3 c) const { return origin + cell * (cast<float>(c) + Vec3{0.5f, 0.5f, 0.5f}); }
  /// Cell of a position, clamped to the grid.
  Int3 cell_of(Vec3 x) const {
    const Vec3 u = (x - origin) * (1 / cell);
    Int3 c;
    for (int a = 0; a < 3; ++a) c[a] = u[a] > 0 ? (u[a] < float(size[a]) ? int(u[a]) : size[a] - 1) : 0;
    return c;
  }
};

/// Calls visit(cell) for the cells that a box touches, `reach` to each side of x; clamped like cell_of.
template <class Visit>
void visit_around(const CellGrid& grid, const Vec3& x, float reach, Visit&& visit) {
  const Vec3 side{reach, reach, reach};
  const Int3 lo = grid.cell_of(x - side), hi = grid.cell_of(x + side);
  for (int cx = lo.x; cx <= hi.x; ++cx)
    for (int cy = lo.y; cy <= hi.y; ++cy)
      for (int cz = lo.z; cz <= hi.z; ++cz) visit(grid.index({cx, cy, cz}));
}

/// One value per cell of a grid.
struct CellValues {
  static constexpr float kLowest = -std::numeric_limits<float>::infinity();

  CellGrid grid;
  std::vector<float> values;

  CellValues() = default;
  CellValues(const CellGrid& cells, float everywhere) : grid(cells), values(cells.cells(), everywhere) {}
  float at(Vec3 x) const { return values[grid.index(grid.cell_of(x))]; }
  void raise(std::size_t cell, float value) {
    if (value > values[cell]) values[cell] = value;
  }
};

/// Each cell's largest value among its own and those of its neighbours, diagonals included.
CellValues dilate(CellValues in);

}  // namespace splinevox
