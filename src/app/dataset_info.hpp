// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "app/support.hpp"

namespace splinevox::app {

/// What `info` understood of a data set: layout, splits, times, lenses, where cameras look, the box, what is odd. Throws Error (input).
Json dataset_json(const std::string& path);
void print_dataset(const Json& j);

}  // namespace splinevox::app
