// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "train/bounds/offset.hpp"
#include "train/volume.hpp"

namespace splinevox {

/// Freezes motion where there is none, if that is in most of what pictures show. Of many scenes only a part
/// moves, and what is static need not pay for that. Early in a run it cannot be told: a fit displaces
/// everything, what is static by a voxel or two, but always by the same. Once all of time is trained, the
/// displacement of a place over time tells the two apart; then the canonical volume is laid out anew such
/// that the offset is 0, and where nothing else is left motion is not stored, read or learned
/// (docs/experiments/static.md).
/// @param voxel  of the next stage, scene units
/// @return the offset at which the canonical volume is to be looked at from now on; none if nothing is
/// frozen. With one, the occupancy must be refreshed once the volume is laid out anew.
std::optional<Offset> freeze(const Setting& setting, Volume& volume, const TimeWindow& window, float voxel);

}  // namespace splinevox
