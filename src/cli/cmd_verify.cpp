// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "data/message_text.hpp"
#include "run/events.hpp"
#include "run/run_folder.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

namespace splinevox::cli {

Action verify_command(CLI::App& verb) {
  struct Options {
    std::string folder;
    bool json = false;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("RUN|EXPORT_DIR", o->folder, "a folder with a manifest.json")->required();
  add_json(verb, o->json);
  return [o] {
    int bad = 0;
    Json files = Json::array();
    std::vector<FileCheck> checks = verify(o->folder);
    for (FileCheck& c : checks)
      if (c.ok && c.file == "config.toml") try {
          Config config;
          RunRecord record;
          read_run_config(o->folder, config, record);
        } catch (const Error& e) {
          if (e.fault == Fault::memory) throw;
          c = {c.file, false, e.problem.what};
        }
    for (const FileCheck& c : checks) {
      bad += c.ok ? 0 : 1;
      files.push_back({{"file", c.file}, {"ok", c.ok}, {"problem", c.problem}});
      if (!o->json)
        fmt::print("{:<4} {}{}{}\n", c.ok ? "ok" : "BAD", data::printable(c.file), c.ok ? "" : ": ",
                   data::printable(c.problem));
    }
    if (o->json)
      write_event("result", {{"folder", o->folder}, {"bad", bad}, {"files", files}});
    else
      fmt::print("{} of {} files are whole\n", checks.size() - std::size_t(bad), checks.size());
    return bad ? 2 : 0;
  };
}

}  // namespace splinevox::cli
