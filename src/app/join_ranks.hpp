// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "splinevox/train/ranks.hpp"

namespace splinevox::app {

/// Where this process stands among those that one mpirun or srun has started, by the environment they set.
struct Place {
  int rank = 0, count = 1;
};
Place launched_place();

/// Joins the processes that mpirun started; null if it started none but this. They part again when the object goes, unless by an exception:
/// then the launcher ends them all. Throws Error (input) where there are several and the build has no MPI.
std::unique_ptr<Ranks> join_ranks();

}  // namespace splinevox::app
