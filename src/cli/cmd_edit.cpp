// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "core/atomic_file.hpp"
#include "io/manifest.hpp"
#include "run/edit_session.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "run/teller.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/model_vdb.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

struct EditVerb {
  std::string run, out;
  int threads = 0;
  TalkWords talk;
};

/// One operation with its value.
struct Asked {
  std::string operation, value;
};

/// The operations in the order in which they were written: CLI11 keeps the values of each option, and which
/// option came when.
std::vector<Asked> in_order(const CLI::App& verb, const std::vector<CLI::Option*>& options) {
  std::vector<Asked> asked;
  std::map<const CLI::Option*, std::size_t> next;
  for (const CLI::Option* option : verb.parse_order())
    for (std::size_t i = 0; i < options.size(); ++i)
      if (options[i] == option)
        asked.push_back({edit_operations()[i].name,
                         edit_operations()[i].value ? option->results()[next[option]++] : std::string()});
  return asked;
}

int edit(const EditVerb& o, const std::vector<Asked>& asked) {
  if (asked.empty())
    fail({"edit", "there is nothing to do", "one operation or more", "", "splinevox edit --help lists them"});
  if (fs::exists(fs::path(o.out) / "config.toml"))
    fail({o.out, "this folder already holds a run", "a name that is free: a run is never changed", "",
          "another folder for --out"});
  Run run = open_run(o.run);
  const std::string from = run.path;
  const ModelNotes notes = run.notes;
  RunFolder folder(o.out, false);
  Json steps = read_history_if_there(from + "/" + kEditHistory);
  const Teller teller(choose_talk(o.talk.quiet, o.talk.json));
  EditSession session(std::move(run), [&](const std::string& line) { teller.note(line); });
  for (const Asked& a : asked) session.apply(a.operation, a.value);
  steps.push_back({{"from", fs::absolute(from).lexically_normal().string()},
                   {"splinevox", kVersion},
                   {"operations", session.done()}});
  Manifest manifest{"run", {{"splinevox", kVersion}, {"edited", "yes"}}, {}};
  const std::string config = read_text(from + "/config.toml");
  // The model first: one that cannot be written leaves no run behind.
  const FileDigest model = save_model(folder.file("model.vdb"), session.model(), notes);
  manifest.files.push_back({"config.toml", write_file(folder.file("config.toml"), {config}), {}});
  manifest.files.push_back({"model.vdb", model, {}});
  manifest.files.push_back(
      {kEditHistory, write_file(folder.file(kEditHistory), {json_text({{"history", steps}}, 2) + "\n"}), {}});
  write_manifest(folder.path(), manifest);
  teller.result({{"out", folder.path()}, {"operations", session.done()}}, folder.path());
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
