// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/simd.hpp"
#include "field/lattice/brick_view.hpp"
#include "math/trilinear.hpp"

namespace splinevox {

/// Neighbouring columns of the rows around a position, interpolated, with their derivatives by the fractions;
/// those that nobody reads cost nothing.
/// @tparam V  a register of as many columns. @param values  [rows * width]. @param offset  of the first
/// column.
template <class V, class Real, class Stored>
SPLINEVOX_INLINE TrilinearValue<V> gather(const CellRows& rows, const Vec3T<Real>& fraction,
                                          const Stored* values, int width, int offset) {
  const auto corner = [&](int c) { return load<V>(values + std::size_t(rows.row[c]) * width + offset); };
  return trilinear_with_gradient(fraction, corner(0), corner(1), corner(2), corner(3), corner(4), corner(5),
                                 corner(6), corner(7));
}

}  // namespace splinevox
