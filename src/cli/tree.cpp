// SPDX-License-Identifier: Apache-2.0
#include "cli/tree.hpp"

#include <fmt/format.h>

#include "cli/options.hpp"
#include "run/support.hpp"

namespace splinevox::cli {
namespace {

struct Verb {
  const char* name;
  const char* summary;
  Action (*define)(CLI::App&);
  const char* group;
};

constexpr const char *kGet = "Get a data set", *kMake = "Reconstruct", *kLook = "Measure and compare",
                     *kUse = "Take it elsewhere", *kShell = "This program in your shell";

constexpr Verb kVerbs[] = {
    {"synth", "a procedural moving scene with exact ground truth", synth_command, kGet},
    {"capture", "a data set from films or bare pictures, with COLMAP's cameras", capture_command, kGet},
    {"convert", "write a data set of any layout as a D-NeRF folder", convert_command, kGet},
    {"info", "what is in a run, an export, a VDB file or a data set", info_command, kGet},
    {"train", "reconstruct a moving scene from posed pictures", train_command, kMake},
    {"sweep", "many trainings from one description, here or as a Slurm array, and their table", sweep_command,
     kMake},
    {"edit", "change the motion of a run: time, size, basis, moving parts", edit_command, kMake},
    {"eval", "compare renders of a run with held-out pictures", eval_command, kLook},
    {"report", "one page with curves, pictures and tables of runs", report_command, kLook},
    {"verify", "check every file that a manifest lists", verify_command, kLook},
    {"export", "an animated sequence of a run: OpenVDB or Gaussian splats", export_command, kUse},
    {"render", "pictures or a film of a run", render_command, kUse},
    {"view", "one page that shows a run from anywhere at any time", view_command, kUse},
    {"track", "carry points of one time to other times", track_command, kUse},
    {"import", "Gaussian splats as a VDB sequence", import_command, kUse},
    {"man", "the manual page, to be read with `man -l -`", man_command, kShell},
    {"completion", "a shell's completion script", completion_command, kShell},
};

OptionEntry describe_option(const CLI::Option& o) {
  OptionEntry e;
  for (const std::string& n : o.get_snames()) e.names.push_back("-" + n);
  for (const std::string& n : o.get_lnames()) e.names.push_back("--" + n);
  e.text = o.get_description();
  e.usual = o.get_default_str();
  e.group = o.get_group();
  e.required = o.get_required();
  e.repeats = o.get_items_expected_max() > 1;
  if (o.get_items_expected_max() == 0) return e;
  const std::string type = o.get_type_name();  // NAME, NAME:TYPE in [RANGE], or {CHOICES} anywhere in it
  const std::size_t open = type.find('{'), close = type.find('}'), range = type.find(" in ["),
                    colon = range == type.npos ? range : type.find(':');
  if (open < close && close != type.npos) {
    e.choices = split_list(type.substr(open + 1, close - open - 1));
    e.value = open == 0 ? "NAME" : type.substr(0, std::min(type.find(':'), open));
  } else {
    e.value = type.substr(0, colon);
    if (colon != type.npos) e.range = type.substr(colon + 1);
  }
  if (e.positional()) e.value = o.get_name();
  return e;
}

}  // namespace

std::string OptionEntry::facts() const {
  std::vector<std::string> known;
  if (required) known.push_back("required");
  if (!choices.empty() && text.find('\n') == text.npos)
    known.push_back(fmt::format("one of {}", fmt::join(choices, ", ")));
  if (!range.empty()) known.push_back(range);
  if (!usual.empty()) known.push_back("default: " + usual);
  return fmt::format("{}", fmt::join(known, "; "));
}

std::string VerbEntry::synopsis() const {
  std::string words = name;
  for (const OptionEntry& o : options)
    if (o.positional()) {
      const std::string place = o.value + (o.repeats ? " ..." : "");
      words += o.required ? " " + place : " [" + place + "]";
    }
  for (const OptionEntry& o : options)
    if (!o.positional() && o.required) words += fmt::format(" {} {}", o.names.front(), o.value);
  return words + " [OPTION]...";
}

std::vector<std::pair<CLI::App*, Action>> declare_verbs(CLI::App& app) {
  std::vector<std::pair<CLI::App*, Action>> verbs;
  for (const Verb& v : kVerbs) {
    CLI::App* verb = app.add_subcommand(v.name, v.summary)->group(v.group);
    verbs.emplace_back(verb, v.define(*verb));
  }
  return verbs;
}

std::vector<VerbEntry> describe(const CLI::App& app) {
  std::vector<VerbEntry> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string name = verb->get_name();
    VerbEntry v{name, verb->get_description(), verb->get_footer(), verb->get_group(), {}, examples_of(name)};
    for (const CLI::Option* option : verb->get_options())
      if (option != verb->get_help_ptr()) v.options.push_back(describe_option(*option));
    v.options.push_back(describe_option(*verb->get_help_ptr()));
    v.options.back().group = kTalk;
    verbs.push_back(std::move(v));
  }
  return verbs;
}

}  // namespace splinevox::cli
