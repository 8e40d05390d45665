// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/columns.hpp"
#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// Some columns of a field as a grid, every stored vertex active; `meta` and the column's role go into its
/// metadata.
VdbGrid to_grid(const Channels& channels, const Column& column, const VdbMeta& meta, bool half);

}  // namespace splinevox
