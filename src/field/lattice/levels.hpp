// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/row_mask.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Interpolates a coarse level at the given vertices of one brick of a fine level and adds it: fine +=
/// coarse.
///
/// The lattices are nested (same origin, half the spacing, same width), so a trilinear function on the coarse
/// one is exactly a trilinear function on the fine one: a sum of levels can be stored, sampled and
/// differentiated on the finest alone.
void prolong_brick(const Channels& coarse, Channels& fine, int fine_brick, const RowMask& rows);

/// Adjoint of prolong_brick over all fine bricks, for the rows of one coarse brick: coarse +=
/// transpose(prolong) fine. Fine rows outside `fine_rows` ([bricks + 1]) are taken to be 0; coarse rows that
/// anything arrives at are marked. Bricks are independent.
void restrict_brick(const Channels& fine, const std::vector<RowMask>& fine_rows, Channels& coarse,
                    int coarse_brick, RowMask& touched);

}  // namespace splinevox
