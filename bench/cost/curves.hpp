// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox::cost {

/// PSNR of the held-out view against seconds of training, one line per run, from the runs' metrics.jsonl. A
/// whole SVG file. Throws Error (input) for a folder without such lines.
std::string curves(const std::vector<std::string>& runs);

}  // namespace splinevox::cost
