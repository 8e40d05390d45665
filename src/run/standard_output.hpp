// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace splinevox::run {

/// Standard output of a program whose exit code tells whether some of it was lost. A flush that fails takes
/// what was in the buffer with it, and the next one succeeds: so the first failure is kept here.
/// @{
/// Writes what was printed so far, and drops what cannot be written.
void flush_output();
/// Prints a text and flushes.
void print_now(const std::string& text);
/// errno of the first flush that failed; 0: none did.
int output_failure();
/// @}

}  // namespace splinevox::run
