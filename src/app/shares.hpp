// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "splinevox/core/share.hpp"

namespace splinevox::app {

/// --share K/N: of the frames or pictures only every N-th, from the K-th on.
void add_share(CLI::App& verb, std::string& share);
/// What that option says, or where this process stands among those that one mpirun has started. Throws Error (input).
Share chosen_share(const std::string& text);
/// Where this process stands among those that one mpirun or srun has started, by the environment they set.
Share launched_share();

}  // namespace splinevox::app
