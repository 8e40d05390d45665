// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "run/edit_run.hpp"
#include "run/edit_session.hpp"
#include "run/teller.hpp"

namespace splinevox::cli {
namespace {

struct EditVerb {
  std::string run, out;
  int threads = 0;
  TalkWords talk;
};

/// The operations in the order in which they were written: CLI11 keeps the values of each option, and which
/// option came when.
std::vector<AskedEdit> in_order(const CLI::App& verb, const std::vector<CLI::Option*>& options) {
  std::vector<AskedEdit> asked;
  std::map<const CLI::Option*, std::size_t> next;
  for (const CLI::Option* option : verb.parse_order())
    for (std::size_t i = 0; i < options.size(); ++i)
      if (options[i] == option)
        asked.push_back({edit_operations()[i].name,
                         edit_operations()[i].value ? option->results()[next[option]++] : std::string()});
  return asked;
}

int edit(const EditVerb& o, const std::vector<AskedEdit>& asked) {
  const Teller teller(choose_talk(o.talk.quiet, o.talk.json));
  const EditedRun made = edit_run(o.run, o.out, asked, [&](const std::string& line) { teller.note(line); });
  teller.result({{"out", made.folder}, {"operations", made.operations}}, made.folder);
  return 0;
}

}  // namespace

Action edit_command(CLI::App& verb) {
  auto o = std::make_shared<EditVerb>();
  auto options = std::make_shared<std::vector<CLI::Option*>>();
  auto values = std::make_shared<std::vector<std::vector<std::string>>>(edit_operations().size());
  verb.add_option("RUN", o->run, "the run to start from; it stays as it is")->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder for the new run")->required();
  for (std::size_t i = 0; i < edit_operations().size(); ++i) {
    const EditOperation& e = edit_operations()[i];
    const std::string name = std::string("--") + e.name;
    if (e.value)
      options->push_back(verb.add_option(name, (*values)[i], e.help)
                             ->expected(1)
                             ->take_all()
                             ->allow_extra_args(false)
                             ->type_name(e.value)
                             ->group(e.group));
    else
      options->push_back(verb.add_flag(name, e.help)->group(e.group));
  }
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  verb.footer(
      "Operations are done in the order in which they are written. The new run has no training to go on "
      "with; render, export, track, view, info, verify and eval work on it as on any other.");
  return [o, options, values, &verb] {
    return with_threads(o->threads, [&] { return edit(*o, in_order(verb, *options)); });
  };
}

}  // namespace splinevox::cli
