// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace splinevox::run {

/// Runs a program's work and turns what it throws into a message on standard error and an exit code: 0 done,
/// 2 wrong input, 1 anything else, also output that standard output did not take (a full disk; a reader that
/// went away is no error). Closed pipes and file size limits are errors of the write, not signals. For `main`
/// of every program.
/// @param program  the name that messages begin with.
int exit_code_of(const char* program, const std::function<int()>& work);

}  // namespace splinevox::run
