// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace splinevox {

/// The text of the TOML file at `path`, fit for the parser: TOML 1.0 has characters beyond ASCII in strings
/// and comments alone, and toml++ 3.3 runs into an unreachable branch for some of them elsewhere. Also
/// refused, for the same branch, are such characters in strings of several lines. Throws Error for a file
/// that is not there or not readable.
std::string toml_text(const std::string& path);

}  // namespace splinevox
