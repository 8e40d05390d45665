// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/io/export_vdb.hpp"

namespace splinevox::run {

/// What --share K/N says, or where this process stands among those that one mpirun has started. Throws Error
/// (input).
Share chosen_share(const std::string& text);
/// Where this process stands among those that one mpirun or srun has started, by the environment they set.
Share launched_share();

}  // namespace splinevox::run
