// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "run/support.hpp"
#include "splinevox/train/prepare.hpp"

namespace splinevox::run {

/// What RUN/effects.json holds: every effect with its gain, cost and decision, and every fit behind it
/// (docs/formats.md).
Json effects_json(const Prepared& prepared);

/// The same in a line: "effects: motion (+6.10 dB), rigidity, view; without light (-0.08 dB)"; then one for
/// each thing to say of it, indented.
std::vector<std::string> effects_lines(const Json& effects);

/// A table of them as HTML; empty if `effects` is no effects.json.
std::string effects_table(const Json& effects);

}  // namespace splinevox::run
