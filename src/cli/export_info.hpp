// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "run/support.hpp"

/// What `info` says of the folder of an export.
namespace splinevox::cli {

/// None: the folder has no list of an export, finished or not. Throws Error (input).
std::optional<Json> export_json(const std::string& folder);
void print_export(const Json& exported);

/// Numbers of frames in words: "1-24, 48". @param frames  in order
std::string frames_text(const std::vector<int>& frames);

}  // namespace splinevox::cli
