// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "field/columns.hpp"
#include "field/lattice/brick_view.hpp"
#include "math/warp.hpp"

namespace splinevox {

/// Read-only bit per cell of a regular grid over the box: set where there may be matter at one time.
template <class Real>
struct OccupancyView {
  Vec3T<Real> origin{};
  Real inv_cell = 1;
  Int3 size{1, 1, 1};                   ///< cells per axis
  const std::uint32_t* bits = nullptr;  ///< null: everything is occupied

  SPLINEVOX_HD bool occupied(const Vec3T<Real>& x) const {
    return occupied_at(
        {(x[0] - origin[0]) * inv_cell, (x[1] - origin[1]) * inv_cell, (x[2] - origin[2]) * inv_cell});
  }
  /// The same for a position in cells from the origin.
  SPLINEVOX_HD bool occupied_at(const Vec3T<Real>& u) const {
    if (!bits) return true;
    int c[3];
    for (int a = 0; a < 3; ++a) {
      const int i = int(u[a]);
      c[a] = i < 0 ? 0 : i >= size[a] ? size[a] - 1 : i;
    }
    const std::uint32_t index = std::uint32_t((c[0] * size.y + c[1]) * size.z + c[2]);
    return bits[index >> 5] >> (index & 31) & 1;
  }
};

/// The model as the ray kernels read it; all frames share it.
/// @tparam Stored  what the radiance rows are kept in; load<Eight>(const Stored*) makes a register of Real of
/// them.
template <class Real, class Stored = Real>
struct FieldView {
  BrickView<Real> radiance;
  const Stored* radiance_rows = nullptr;  ///< [rows * width]
  BrickView<Real> motion;
  const std::uint32_t* reach = nullptr;  ///< bits of ActiveRows::reach, for RayKernel (a device's kernels
                                         ///< have no registers left for it); null: samples look everywhere
  bool moving = false, rigidity = false;
  int slice_used = kSliceUsed;  ///< floats of a slice's row that are stored
  Real rigidity_offset = 0;
  Real density_scale = 1, density_shift = 0;
  Real step = 1;  ///< scene units
};

/// One time as the ray kernels read it.
template <class Real>
struct FrameView {
  const Real* slice = nullptr;  ///< [motion rows * kSliceWidth]
  OccupancyView<Real> occupancy;
};

/// One ray, clipped to the box: sample i sits at origin + i * step * direction, 0 <= i < count.
template <class Real>
struct RayInput {
  Vec3T<Real> origin, direction;  ///< direction of unit length
  int count = 0;
  Vec3T<Real> background;  ///< colour behind this ray
  Real rest = 0;           ///< weight of rest_vjp of what it shows, 1 / scene unit^2; 0: nothing is asked
  Real weight = 1;         ///< of its photometric loss, above 0
};

}  // namespace splinevox
