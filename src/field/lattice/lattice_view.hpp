// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/hd.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// A topology by its neighbourhoods, for kernels that go from vertex to vertex. Pointers are the executor's.
struct LatticeView {
  const std::int32_t* table = nullptr;  ///< as Topology::table
  const Int3* bricks = nullptr;         ///< as Topology::bricks
  Int3 dims{};
  int brick_count = 0;

  SPLINEVOX_HD std::size_t rows() const { return std::size_t(brick_count + 1) * kBrickRows; }
  /// Brick at a brick coordinate; 0 where it is absent or beyond the table.
  SPLINEVOX_HD std::int32_t brick_at(const Int3& b) const {
    if (b.x < -1 || b.y < -1 || b.z < -1 || b.x > dims.x - 2 || b.y > dims.y - 2 || b.z > dims.z - 2)
      return 0;
    return table[(std::size_t(b.x + 1) * dims.y + (b.y + 1)) * dims.z + (b.z + 1)];
  }
  /// Vertex of a row. @pre the row is not of brick 0.
  SPLINEVOX_HD Int3 vertex(std::size_t row) const {
    const Int3 b = bricks[row / kBrickRows];
    const int i = int(row % kBrickRows);
    return {b.x * kBrick + (i >> 6), b.y * kBrick + (i >> 3 & 7), b.z * kBrick + (i & 7)};
  }
  /// Row of a vertex; one of brick 0 where it is absent.
  SPLINEVOX_HD std::size_t row_of(const Int3& v) const {
    return std::size_t(brick_at({v.x >> 3, v.y >> 3, v.z >> 3})) * kBrickRows +
           ((v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
  }
};

/// Of a topology where it lies, which must outlive the view.
inline LatticeView view_of(const Topology& t) {
  return {t.table.data(), t.bricks.data(), t.dims, t.brick_count()};
}

/// RowMask's bits, all bricks in one array.
SPLINEVOX_HD inline bool test_row(const std::uint64_t* mask, std::size_t row) {
  return mask[row >> 6] >> (row & 63) & 1;
}

}  // namespace splinevox
