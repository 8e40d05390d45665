// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

int main(int argc, char** argv) { return splinevox::mlp::run_command_line(argc, argv); }
