// SPDX-License-Identifier: Apache-2.0
#include "cli/tree.hpp"

#include "run/support.hpp"

namespace splinevox::cli {
namespace {

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
  const std::string type = o.get_type_name();  // NAME, NAME:CHECK, or {CHOICES} anywhere in it
  const std::size_t open = type.find('{'), close = type.find('}'), colon = type.find(':');
  if (open < close && close != type.npos) {
    e.choices = split_list(type.substr(open + 1, close - open - 1));
    e.value = open == 0 ? "NAME" : type.substr(0, std::min(colon, open));
  } else {
    e.value = type.substr(0, colon);
    if (colon != type.npos) e.range = type.substr(colon + 1);
  }
  if (e.positional()) e.value = o.get_name();
  return e;
}

}  // namespace

std::vector<VerbEntry> describe(const CLI::App& app) {
  std::vector<VerbEntry> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    VerbEntry v{verb->get_name(), verb->get_description(), verb->get_footer(), {}};
    for (const CLI::Option* option : verb->get_options()) v.options.push_back(describe_option(*option));
    verbs.push_back(std::move(v));
  }
  return verbs;
}

}  // namespace splinevox::cli
