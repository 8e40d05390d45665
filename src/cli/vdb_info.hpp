// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/command.hpp"
#include "run/support.hpp"

/// What `info` says of a VDB file.
namespace splinevox::cli {

/// Its grids, size, version and metadata. Throws Error (input).
Json vdb_json(const std::string& path);
void print_vdb(const Json& vdb);
/// A table of `vdb_json(path)["grids"]`.
void print_grids(const Json& grids);

}  // namespace splinevox::cli
