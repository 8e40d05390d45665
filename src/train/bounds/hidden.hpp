// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/lattices.hpp"
#include "train/occupancy.hpp"

namespace splinevox {

/// Empties the canonical rows that are not visible, and begins to collect them anew. The inside of a solid is
/// not visible, so only the first fog and the priors shaped what is there. With too few rays it does nothing,
/// and the next emptying has them too. While part of the times is learned it only begins anew.
/// Returns whether bricks were pruned.
bool empty_hidden(const Setting& setting, const TimeWindow& window, Lattices& lattices);

}  // namespace splinevox
