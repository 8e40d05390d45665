// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox::mlp {

/// The program: words in, exit code out (0 done, 2 wrong input, 1 anything else, 128 + signal when
/// interrupted).
int run_command_line(int argc, char** argv);

}  // namespace splinevox::mlp
