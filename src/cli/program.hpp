// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox::cli {

/// The program: does what the words of its command line ask for. Returns the exit code; throws nothing.
int run_program(int argc, char** argv);

}  // namespace splinevox::cli
