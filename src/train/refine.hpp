// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <initializer_list>
#include <vector>

#include "field/lattice/row_mask.hpp"
#include "render/occupancy.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Raw density of what is absent: an alpha of about 1e-6 a step, low enough to be nothing and near enough to
/// learn back from.
inline constexpr float kEmptyDensity = -10;

/// Prunes the bricks in whose cells nothing is left, here and in arrays of rows beside them. Pictures stay as
/// they are but for the millionth of light that an empty step takes. Returns whether any were pruned.
bool prune_empty(Channels& raw, std::initializer_list<AlignedVector<float>*> beside = {});

/// Bricks of a lattice that come within one vertex of a set cell.
TopologyPtr bricks_near(const Lattice& lattice, const BitGrid& cells);

/// Rows whose vertex has a set cell within `reach` of it along every axis, scene units; [bricks + 1], none of
/// the background's.
std::vector<RowMask> rows_near(const Topology& topology, const BitGrid& cells, float reach);

/// The field at the vertices of another topology over the same box, by trilinear interpolation of raw values;
/// where the old one has nothing the background is copied.
/// @param moved  where in the old field to look for a vertex; empty: where the vertex is
Channels resample(const Channels& from, TopologyPtr topology, const std::function<Vec3(Vec3)>& moved = {});

/// Gives every stored curve more control points without changing it, once, as its basis does: a Bezier curve
/// one degree more (K + 1, numerics H3), a cubic B-spline twice as many spans (2K - 3). @pre the basis has a
/// refinement
void elevate(MotionField& motion);

}  // namespace splinevox
