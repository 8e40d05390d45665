// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace splinevox {

/// What kind of thing went wrong; decides the exit code of the command line.
enum class Fault {
  input,    ///< the user's files or arguments: exit code 2
  output,   ///< a file could not be written (full disk, no permission): exit code 1
  numeric,  ///< the computation itself failed (non-finite steps in a row): exit code 1
  memory    ///< there is not enough of it, though nothing is wrong with the input: exit code 1
};

/// One problem as a user reads it: where it is, what is wrong, what was expected, what was found, what to
/// try. `where` and `what` are required; empty fields are left out of the message.
struct Problem {
  std::string where{}, what{}, expected{}, got{}, hint{};
};

/// The only exception thrown on purpose. what() is the full message:
///
///     lego/transforms_train.json, frame 12: 'time' is outside the scene's time range
///       expected: a number in [0, 1]
///       got:      1.37
///       try:      ...
class Error : public std::runtime_error {
 public:
  Error(Problem problem, Fault fault);
  Problem problem;
  Fault fault;
};

/// Throws Error for a mistake in the user's input.
[[noreturn]] void fail(Problem problem);
/// Throws Error for output that could not be written.
[[noreturn]] void fail_output(Problem problem);
/// Throws Error for work that needs more memory than there is.
[[noreturn]] void fail_memory(Problem problem);

}  // namespace splinevox
