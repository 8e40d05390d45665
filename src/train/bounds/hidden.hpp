// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/lattices.hpp"
#include "train/occupancy.hpp"

namespace splinevox {

/// Empties the canonical rows that no ray has shown, if there were rays enough, and begins to look anew. No
/// picture shows the inside of a solid, so nothing but the first fog and the priors shaped what is there.
/// Returns whether bricks went by it.
bool empty_hidden(const Setting& setting, const TimeWindow& window, Lattices& lattices);

}  // namespace splinevox
