// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/lattices.hpp"

namespace splinevox {

/// Learning rate, total variation and shrinkage of every column, for the lattices as they are.
void set_rates(const Config& config, Lattices& lattices);

/// The configuration's priors on curves for the box as it is. @param halvings  of the curves' spans so far
void set_priors(const Config& config, int halvings, Lattices& lattices);

}  // namespace splinevox
