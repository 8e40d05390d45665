// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "cli/command.hpp"
#include "core/ranks.hpp"

namespace splinevox::cli {

/// Joins the processes that mpirun started; null if it started none but this. They part again when the object
/// goes, unless by an exception: then the launcher ends them all. Throws Error (input) where there are
/// several and the build has no MPI.
/// @param verb  what they are to do together, for that message
std::unique_ptr<Ranks> join_ranks(const char* verb);

}  // namespace splinevox::cli
