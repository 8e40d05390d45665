// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/ranks.hpp"
#include "train/engine.hpp"

namespace splinevox {

/// Leaves of a batch what this rank is to compute: every count-th piece of work. All ranks have drawn the
/// same one.
void keep_own_share(const Ranks& ranks, Batch& batch);
/// The same for a device, which wants equally many rays of every frame: of each frame's rays one piece in a
/// row.
void keep_own_rays(const Ranks& ranks, Batch& batch);

/// What all ranks have computed of one batch, added up in the order of the ranks: the same bits on all of
/// them, and on every repetition with as many. Against one rank, floats are added in another order.
PassResult sum_over_ranks(Ranks& ranks, const PassResult& mine);
/// The same for a gradient; sends only rows that some rank has touched. False if a sum is not usable.
bool sum_over_ranks(Ranks& ranks, Gradient& gradient);

}  // namespace splinevox
