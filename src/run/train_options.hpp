// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox::run {

/// "white", "black" or "R,G,B" as three numbers. Throws Error naming --background.
std::vector<float> parse_background(const std::string& text);

}  // namespace splinevox::run
