// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/command.hpp"
#include "run/support.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::cli {

/// What `info` understood of a data set: layout, splits, times, lenses, where cameras look, the box, what is
/// odd. Throws Error (input).
/// @param pixels  whether pictures are decoded too.
Json dataset_json(const std::string& path, const DatasetRules& rules, bool pixels);
void print_dataset(const Json& j);

}  // namespace splinevox::cli
