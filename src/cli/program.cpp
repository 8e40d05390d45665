// SPDX-License-Identifier: Apache-2.0
#include "cli/program.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "cli/command.hpp"
#include "cli/tree.hpp"
#include "core/nearest.hpp"
#include "core/system.hpp"
#include "run/events.hpp"
#include "run/exit_code.hpp"
#include "run/progress.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cli {
namespace {

/// A first word that is no verb, before CLI11 sees it, so that the answer can name the nearest one.
void check_verb(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const VerbEntry& v : describe(app)) {
    if (argv[1] == v.name) return;
    names.push_back(v.name);
  }
  std::string meant = likely(argv[1], names);
  for (int i = 2; meant.empty() && i < argc; ++i)  // the words of others begin with what they are about
    if (std::find(names.begin(), names.end(), argv[i]) != names.end())
      meant = fmt::format("{} {}", argv[i], argv[1]);
  fail({"splinevox", fmt::format("there is no verb '{}'", argv[1]),
        fmt::format("one of {}", fmt::join(names, ", ")), argv[1],
        "splinevox " + (meant.empty() ? "--help" : meant)});
}

/// CLI11's complaint with the nearest option where one was misspelt.
int explain(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  std::string text = error.what(), hint, found;
  const auto verbs = app.get_subcommands();
  const CLI::App& verb = verbs.empty() ? app : *verbs.front();
  for (const std::string& word : verb.remaining()) {
    if (word.rfind("--", 0) != 0) continue;
    std::vector<std::string> known;
    for (const CLI::Option* o : verb.get_options())
      for (const std::string& name : o->get_lnames()) known.push_back("--" + name);
    text = fmt::format("there is no option {}", word);
    found = word;
    hint = likely(word, known);
    break;
  }
  const std::string where = verbs.empty() ? "splinevox" : "splinevox " + verb.get_name();
  fmt::print(stderr, "{}: {}\n", where, text);
  if (!hint.empty()) fmt::print(stderr, "  try:      {}\n", hint);
  fmt::print(stderr, "  help:     {} --help\n", where);
  write_error({where, text, "", found, hint.empty() ? where + " --help" : hint}, Fault::input, 2);
  return 2;
}

/// Columns of a help page: a terminal's, if lines then are no harder to read; 80 for files and pipes.
int help_width() {
  constexpr int kLeast = 60, kMost = 100;
  return std::clamp(columns(STDOUT_FILENO), kLeast, kMost);
}

int run_verb(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (const std::string_view word = argv[i]; word == "--json" || word == "--json=true")
      begin_events(argv[1][0] == '-' ? "" : argv[1]);
  CLI::App app{"Moving scenes as sparse voxel volumes whose motion is a spline", "splinevox"};
  app.set_version_flag("--version", std::string("splinevox ") + kVersion);
  app.set_help_flag("-h,--help", "this page");
  app.require_subcommand(1);
  app.formatter_fn([&app](const CLI::App* shown, const std::string&, CLI::AppFormatMode) {
    for (const VerbEntry& v : describe(app))
      if (shown != &app && v.name == shown->get_name()) return help_page(v, help_width());
    return help_page(app, help_width());
  });
  const auto verbs = declare_verbs(app);
  std::vector<char*> words(argv, argv + argc);
  if (argc > 1 && std::string_view(argv[1]) == "help") {  // splinevox help VERB
    words.erase(words.begin() + 1);
    words.resize(std::min<std::size_t>(words.size(), 2));
    static char kHelp[] = "--help";
    words.push_back(kHelp);
  }
  check_verb(app, int(words.size()), words.data());
  try {
    app.parse(int(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    return explain(app, error);
  }
  for (const auto& [verb, action] : verbs)
    if (verb->parsed()) return action();
  return 2;
}

}  // namespace

int run_program(int argc, char** argv) {
  name_own_program(argv[0]);
  return exit_code_of("splinevox", [&] { return run_verb(argc, argv); });
}

}  // namespace splinevox::cli
