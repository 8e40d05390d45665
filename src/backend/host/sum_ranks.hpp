// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/host/engine.hpp"
#include "core/ranks.hpp"

namespace splinevox {

/// What all ranks have computed of one batch, added up in the order of the ranks: the same bits on all of
/// them, and on every repetition with as many. Against one rank, floats are added in another order.
PassResult sum_over_ranks(Ranks& ranks, const PassResult& mine);
/// The same for a gradient; sends only rows that some rank has touched. False if a sum is not usable.
bool sum_over_ranks(Ranks& ranks, Gradient& gradient);

}  // namespace splinevox
