// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "cli/options.hpp"
#include "core/atomic_file.hpp"
#include "core/own_folder.hpp"
#include "run/folder_mark.hpp"
#include "run/signals.hpp"
#include "run/standard_output.hpp"
#include "run/support.hpp"
#include "run/sweep/sweep.hpp"
#include "run/teller.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

struct SweepVerb {
  std::string description, out;
  int jobs = 1, threads = 0;
  std::optional<int> task;
  bool list = false, table = false;
  TalkWords talk;
};

constexpr FolderMark kSweepMark{"sweep.json", "splinevox sweep"};  ///< in a sweep's folder

/// Makes a folder for lists and tables ours. One that has files of their names which no sweep wrote, as the
/// folder of a paper may, is refused. Sweeps of older versions left no mark: their script tells.
void claim_sweep(const std::string& out) {
  const auto path = [&](const std::string& name) { return (fs::path(out) / name).string(); };
  const std::vector<std::string> there = names_in_folder(out);
  const bool marked = !first_taken(there, {kSweepMark.name}).empty(),
             ours =
                 marked ? has_mark(out, kSweepMark) : is_slurm_script(read_text_if_there(path("array.sh")));
  const std::string taken = first_taken(there, {kSweepMark.name, "tasks.txt", "array.sh", "table.csv",
                                                "settings.csv", "table.md", "table.tex"});
  if (!ours && !taken.empty())
    fail({path(taken), "`sweep` did not write this file and would replace it",
          "a folder of its own, or that of an earlier sweep", "", "another folder for --out"});
  probe_output_folder(out);
  if (!marked) write_mark(out, kSweepMark);
}

int sweep(const SweepVerb& o) {
  if (o.task && (o.list || o.table))
    fail({"--task", "it runs one task, and the others are not looked at", "neither --list nor --table",
          o.list ? "--list" : "--table", ""});
  const Teller teller(choose_talk(o.talk.quiet, o.talk.json));
  std::vector<SweepTask> tasks = read_sweep(o.description, o.out);
  if (o.task)  // which writes its own run only
    probe_output_folder(o.out);
  else
    claim_sweep(o.out);
  const int threads =
      o.threads > 0 ? o.threads : std::max(1, tbb::this_task_arena::max_concurrency() / o.jobs);
  if (o.task) {
    if (*o.task < 0 || std::size_t(*o.task) >= tasks.size())
      fail({"--task", "there is no such task", fmt::format("a number in [0, {}]", tasks.size() - 1),
            std::to_string(*o.task), ""});
    tasks = {tasks[std::size_t(*o.task)]};  // many of these run beside each other
  } else {
    write_file(o.out + "/tasks.txt", {sweep_commands(tasks)});
    std::string script;
    try {
      script = slurm_script(o.description, o.out, tasks.size(), threads);
    } catch (const Error& e) {
      if (o.list) throw;  // who asks for no script may well do without
      teller.warn(fmt::format("there is no script for Slurm: {}", e.what()));
    }
    if (!script.empty()) write_file(o.out + "/array.sh", {script});
  }
  if (o.list) {
    teller.result(
        {{"out", o.out}, {"tasks", tasks.size()}, {"list", o.out + "/tasks.txt"}},
        fmt::format("{} tasks: {}/tasks.txt, for Slurm: sbatch {}/array.sh", tasks.size(), o.out, o.out));
    return 0;
  }
  std::vector<std::string> failed;
  if (!o.table) {
    catch_stop_signals();
    failed = run_sweep(tasks, o.out, o.jobs, threads,
                       [&](const SweepTask& t, std::size_t ended, const std::string& what) {
                         if (o.talk.json)
                           write_event("task", {{"task", t.name},
                                                {"run", t.run},
                                                {"ended", ended},
                                                {"total", tasks.size()},
                                                {"outcome", what}});
                         else
                           teller.note(fmt::format("{} of {}  {}: {}", ended, tasks.size(), t.name, what));
                         run::flush_output();
                       });
  }
  if (!o.task) {
    const Table settings = settings_table(tasks);
    write_file(o.out + "/table.csv", {csv(tasks_table(tasks))});
    write_file(o.out + "/settings.csv", {csv(settings)});
    write_file(o.out + "/table.md", {markdown(settings)});
    write_file(o.out + "/table.tex", {latex(settings)});
    if (teller.text()) fmt::print("{}{}/table.csv\n", markdown(settings), o.out);
  }
  if (stop_asked()) {
    write_event("interrupted", {{"interrupted", true}});
    return kInterrupted;
  }
  teller.result({{"out", o.out}, {"tasks", tasks.size()}, {"failed", failed}}, "");
  return failed.empty() ? 0 : 1;
}

}  // namespace

Action sweep_command(CLI::App& verb) {
  auto o = std::make_shared<SweepVerb>();
  verb.add_option("DESCRIPTION", o->description,
                  "TOML: datasets, presets, seeds, [settings], train; see docs/scaling.md")
      ->required();
  heading(verb, "Tasks");
  verb.add_option("--out", o->out, "folder of all runs, their logs and the tables")->required();
  verb.add_option("--jobs", o->jobs, "trainings at a time")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  verb.add_option("--threads", o->threads, "of each training, 0 = the cores shared out")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  verb.add_option("--task", o->task, "only this task, counted from 0: what an array job calls");
  verb.add_flag("--list", o->list, "only write the list of tasks and the script for a Slurm array");
  verb.add_flag("--table", o->table, "only collect the table of what is done");
  add_talk(verb, o->talk);
  return [o] { return sweep(*o); };
}

}  // namespace splinevox::cli
