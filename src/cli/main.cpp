// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "cli/command.hpp"
#include "core/nearest.hpp"
#include "core/system.hpp"
#include "run/exit_code.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::cli;

struct Verb {
  const char* name;
  const char* summary;
  Action (*define)(CLI::App&);
};

constexpr Verb kVerbs[] = {
    {"train", "reconstruct a moving scene from posed pictures", train_command},
    {"eval", "compare renders of a run with held-out pictures", eval_command},
    {"render", "pictures or a film of a run", render_command},
    {"track", "carry points of one time to other times", track_command},
    {"edit", "change the motion of a run: time, size, basis, moving parts", edit_command},
    {"export", "an animated sequence of a run: OpenVDB or Gaussian splats", export_command},
    {"import", "Gaussian splats as a VDB sequence", import_command},
    {"info", "what is in a run, an export, a VDB file or a data set", info_command},
    {"capture", "a data set from films or bare pictures, with COLMAP's cameras", capture_command},
    {"convert", "write a data set of any layout as a D-NeRF folder", convert_command},
    {"verify", "check every file that a manifest lists", verify_command},
    {"synth", "a procedural moving scene with exact ground truth", synth_command},
    {"report", "one page with curves, pictures and tables of runs", report_command},
    {"view", "one page that shows a run from anywhere at any time", view_command},
    {"sweep", "many trainings from one description, here or as a Slurm array, and their table",
     sweep_command},
    {"man", "the manual page, to be read with `man -l -`", man_command},
    {"completion", "a shell's completion script", completion_command},
};

/// A first word that is no verb, before CLI11 sees it, so that the answer can name the nearest one.
void check_verb(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const Verb& v : kVerbs) {
    if (argv[1] == std::string(v.name)) return;
    names.emplace_back(v.name);
  }
  fail({"splinevox", fmt::format("there is no verb '{}'", argv[1]),
        fmt::format("one of {}", fmt::join(names, ", ")), argv[1], "splinevox " + nearest(argv[1], names)});
}

/// CLI11's complaint with the nearest option where one was misspelt.
int explain(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  std::string text = error.what(), hint;
  const auto verbs = app.get_subcommands();
  const CLI::App& verb = verbs.empty() ? app : *verbs.front();
  for (const std::string& word : verb.remaining()) {
    if (word.rfind("--", 0) != 0) continue;
    std::vector<std::string> known;
    for (const CLI::Option* o : verb.get_options())
      for (const std::string& name : o->get_lnames()) known.push_back("--" + name);
    text = fmt::format("there is no option {}", word);
    hint = nearest(word, known);
    break;
  }
  fmt::print(stderr, "splinevox{}: {}\n", verbs.empty() ? "" : " " + verb.get_name(), text);
  if (!hint.empty()) fmt::print(stderr, "  try:      {}\n", hint);
  fmt::print(stderr, "  help:     splinevox {}--help\n", verbs.empty() ? "" : verb.get_name() + " ");
  return 2;
}

int run_verb(int argc, char** argv) {
  check_verb(argc, argv);
  CLI::App app{"Moving scenes as sparse voxel volumes whose motion is a spline", "splinevox"};
  app.set_version_flag("--version", std::string("splinevox ") + kVersion);
  app.require_subcommand(1);
  std::vector<std::pair<CLI::App*, Action>> verbs;
  for (const Verb& v : kVerbs) {
    CLI::App* verb = app.add_subcommand(v.name, v.summary);
    verbs.emplace_back(verb, v.define(*verb));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return explain(app, error);
  }
  for (const auto& [verb, action] : verbs)
    if (verb->parsed()) return action();
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  name_own_program(argv[0]);
  return exit_code_of("splinevox", [&] { return run_verb(argc, argv); });
}
