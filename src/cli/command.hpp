// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace splinevox::run {}

namespace splinevox::cli {

using namespace run;  // the verbs are made of it

/// What a verb does once its options are parsed; the result is the exit code.
using Action = std::function<int()>;

/// Each declares the options of one verb on its subcommand and returns what to do.
Action train_command(CLI::App& verb);
Action eval_command(CLI::App& verb);
Action render_command(CLI::App& verb);
Action export_command(CLI::App& verb);
Action capture_command(CLI::App& verb);
Action convert_command(CLI::App& verb);
Action import_command(CLI::App& verb);
Action info_command(CLI::App& verb);
Action verify_command(CLI::App& verb);
Action synth_command(CLI::App& verb);
Action report_command(CLI::App& verb);
Action track_command(CLI::App& verb);
Action edit_command(CLI::App& verb);
Action view_command(CLI::App& verb);
Action sweep_command(CLI::App& verb);
Action man_command(CLI::App& verb);
Action completion_command(CLI::App& verb);

}  // namespace splinevox::cli
