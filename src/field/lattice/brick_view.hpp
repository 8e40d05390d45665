// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/hd.hpp"
#include "math/trilinear.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// The eight rows around a position.
struct CellRows {
  std::int32_t row[kCorners];
};

/// A cell of the brick table: base vertex as table slot and local coordinates. What a gather needs, and what
/// a scatter is sorted by.
struct Cell {
  std::int32_t slot;   ///< table index of the base vertex' brick
  std::int32_t local;  ///< x * 64 + y * 8 + z of the base vertex inside its brick
  SPLINEVOX_HD int x() const { return local >> 6; }
  SPLINEVOX_HD int y() const { return local >> 3 & 7; }
  SPLINEVOX_HD int z() const { return local & 7; }
  /// All eight corners lie in the base vertex' own brick.
  SPLINEVOX_HD bool interior() const { return x() != 7 && y() != 7 && z() != 7; }
  /// Stands for a cell that is not read, because motion is frozen there (render/active_rows.hpp).
  SPLINEVOX_HD static constexpr Cell frozen() { return {-1, 0}; }
  SPLINEVOX_HD bool is_frozen() const { return slot < 0; }
};

/// Read-only topology for kernels. Real is the scalar of positions.
template <class Real>
struct BrickView {
  Vec3T<Real> origin{};  ///< of vertex 0 of the ring: lattice origin minus 8 vertices
  Real inv_spacing = 1;
  Vec3T<Real> limit{};                      ///< largest base coordinate: 8 * dims - 2
  std::int32_t stride_x = 0, stride_y = 0;  ///< table strides; z has stride 1
  const std::int32_t* table = nullptr;

  BrickView() = default;
  explicit BrickView(const Topology& t)
      : inv_spacing(Real(1) / Real(t.lattice.spacing)),
        stride_x(t.dims.y * t.dims.z),
        stride_y(t.dims.z),
        table(t.table.data()) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = Real(t.lattice.origin[a]) - Real(kBrick) * Real(t.lattice.spacing);
      limit[a] = Real(kBrick * t.dims[a] - 2);
    }
  }

  /// Position -> coordinate along one axis, in vertices of the ring; anything outside the lattice, NaN
  /// included, is clamped into the ring, where every brick is absent.
  SPLINEVOX_INLINE Real coordinate(Real x, int axis) const {
    return clamped((x - origin[axis]) * inv_spacing, axis);
  }
  /// A coordinate, clamped in this way.
  SPLINEVOX_INLINE Real clamped(Real u, int axis) const {
    u = u > Real(0) ? u : Real(0);
    return u < limit[axis] ? u : limit[axis];
  }
  /// Base vertex (ring coordinates) -> cell.
  SPLINEVOX_INLINE Cell cell(int x, int y, int z) const {
    return {(x >> 3) * stride_x + (y >> 3) * stride_y + (z >> 3), (x & 7) << 6 | (y & 7) << 3 | (z & 7)};
  }
  SPLINEVOX_INLINE CellRows rows(const Cell& c) const {
    CellRows r;
    if (c.interior()) {
      const std::int32_t base = table[c.slot] * kBrickRows + c.local;
      r.row[0] = base;
      r.row[1] = base + 1;
      r.row[2] = base + 8;
      r.row[3] = base + 9;
      r.row[4] = base + 64;
      r.row[5] = base + 65;
      r.row[6] = base + 72;
      r.row[7] = base + 73;
      return r;
    }
    const bool ex = c.x() == 7, ey = c.y() == 7, ez = c.z() == 7;
    const std::int32_t sx = ex ? stride_x : 0, sy = ey ? stride_y : 0, sz = ez ? 1 : 0;
    const std::int32_t lx = ex ? -7 * 64 : 64, ly = ey ? -7 * 8 : 8, lz = ez ? -7 : 1;
    for (int i = 0; i < kCorners; ++i) {
      const std::int32_t slot = c.slot + (i & 4 ? sx : 0) + (i & 2 ? sy : 0) + (i & 1 ? sz : 0);
      r.row[i] = table[slot] * kBrickRows + c.local + (i & 4 ? lx : 0) + (i & 2 ? ly : 0) + (i & 1 ? lz : 0);
    }
    return r;
  }
};

}  // namespace splinevox
