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
  /// What is known of it beside its text: "required; one of a, b; default: a". May be empty.
  std::string facts() const;
};

/// A command line that can be typed as it stands, and what it is for.
struct Example {
  std::string words, purpose;
};

struct VerbEntry {
  std::string name, summary, footer;
  std::string group;  ///< heading in the help of the program
  std::vector<OptionEntry> options;
  std::vector<Example> examples;

  /// Its positionals and required options behind its name, and whether there are others:
  /// "train DATASET [OPTION]...".
  std::string synopsis() const;
};

/// Declares every verb on `app`, in the order of use; returns what each does.
std::vector<std::pair<CLI::App*, std::function<int()>>> declare_verbs(CLI::App& app);
/// The command line as it was declared: every verb with its options, in their order. Whoever describes it, to
/// people or to shells, begins here, so that nothing is written down twice.
std::vector<VerbEntry> describe(const CLI::App& app);
/// The way of a scene from pictures to other programs, one command after the other.
const std::vector<Example>& order_of_use();
/// At least two for every verb. Empty: there is no such verb.
std::vector<Example> examples_of(const std::string& verb);

/// What `splinevox --help` and, for a verb, `splinevox VERB --help` print. Neither words nor examples are
/// split. @param width  most columns of a line, at least 60; an example has up to 80
std::string help_page(const CLI::App& app, int width);
std::string help_page(const VerbEntry& verb, int width);

/// Manual page of section 1 (troff, man macros).
std::string man_page(const CLI::App& app, const std::string& version);

/// Names of the shells that completion() knows.
const std::vector<std::string>& completion_shells();
/// Completion script for one of them. Throws Error (input) naming them.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace splinevox::cli
