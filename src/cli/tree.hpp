// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace splinevox::cli {

/// One option or positional of a verb, as its declaration says.
struct OptionEntry {
  std::vector<std::string> names;  ///< "-h", "--help"; empty: a positional
  std::string value;               ///< name of its value, e.g. "INT", or of the positional; empty: a flag
  std::string range;               ///< what the value may be, e.g. "INT in [0 - 4096]"; may be empty
  std::string usual;               ///< default value; may be empty
  std::string text;
  std::string group;                 ///< heading in the help
  std::vector<std::string> choices;  ///< every value it takes, where that is a short list
  bool required = false, repeats = false;

  bool positional() const { return names.empty(); }
};

struct VerbEntry {
  std::string name, summary, footer;
  std::vector<OptionEntry> options;
};

/// The command line as it was declared: every verb with its options, in their order. Whoever describes it, to
/// people or to shells, begins here, so that nothing is written down twice.
std::vector<VerbEntry> describe(const CLI::App& app);

/// Manual page of section 1 (troff, man macros).
std::string man_page(const CLI::App& app, const std::string& version);

/// Names of the shells that completion() knows.
const std::vector<std::string>& completion_shells();
/// Completion script for one of them. Throws Error (input) naming them.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace splinevox::cli
