// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "train/bounds/offset.hpp"
#include "train/volume.hpp"

namespace splinevox {

/// Freezes motion in static regions, if most of what is visible is static. In many scenes only a part moves,
/// and the static one need not pay for that.
///
/// Early in a run the two look alike: a fit displaces everything, static matter by a voxel or two, but always
/// by the same. Once all of time is trained, the spread of a displacement over time separates them. Then the
/// canonical volume is laid out anew such that the offset of static matter is 0. Where nothing else is left,
/// motion is not stored, read or learned (docs/experiments/static.md).
/// Where cameras that stand still proved before the first step what can change (still/changing_cells.hpp),
/// the rest is frozen from the first step on, and the fit is not asked.
/// @param voxel  of the next stage, scene units
/// @return the offset at which the caller must resample the canonical volume; none if nothing is frozen. With
/// one, the occupancy must be refreshed afterwards.
std::optional<Offset> freeze(const Setting& setting, Volume& volume, const TimeWindow& window, float voxel);

}  // namespace splinevox
