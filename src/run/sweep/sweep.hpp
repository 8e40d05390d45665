// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "run/support.hpp"
#include "run/sweep/table.hpp"

namespace splinevox::run {

/// One training with its evaluation.
struct SweepTask {
  std::string name;  ///< of its run folder: dataset_preset_setting_sSEED
  std::string dataset, preset, setting, seed;
  std::vector<std::string> train;  ///< words for `splinevox`
  std::string run;                 ///< its folder
};

/// Reads a description (TOML): datasets, presets, seeds, [settings] of name = list of group.key=value, train
/// = words for every training. Every combination is a task, in the order of the lists. @param out  folder of
/// all runs. Throws Error (input) naming the line or key.
std::vector<SweepTask> read_sweep(const std::string& path, const std::string& out);

/// How far a task is, by its run folder.
struct SweepState {
  bool trained = false, done = false;  ///< done: evaluated as well
  Json metrics;                        ///< metrics.json, if done
  std::string effects;                 ///< names of those that it uses, if done
  std::string fault;                   ///< why its files cannot tell; empty: they can
};
SweepState state_of(const SweepTask& task);

/// A line for each task: names, what came of it, the effects that were chosen, commit and machine; nothing
/// where it is not done.
Table tasks_table(const std::vector<SweepTask>& tasks);
/// A line for each dataset, preset and setting: seeds done, means over them (of PSNR with half the distance
/// of best and worst), effects, commit and machine of all of them.
Table settings_table(const std::vector<SweepTask>& tasks);
/// What a shell would be told to do each task, one a line.
std::string sweep_commands(const std::vector<SweepTask>& tasks);
/// Slurm's script for an array with one task each.
std::string slurm_script(const std::string& description, const std::string& out, std::size_t tasks,
                         int threads);
/// Whether a file is such a script, of any version.
bool is_slurm_script(std::string_view text);

/// Trains and evaluates what is not done yet, in as many processes at a time as `jobs`; what they say goes to
/// NAME.log beside the runs. A signal to stop is waited for: the runs save themselves and go on next time.
/// Returns the tasks that failed.
/// @param on_end  hears what became of a task, the `ended`-th of them that is over
std::vector<std::string> run_sweep(
    const std::vector<SweepTask>& tasks, const std::string& out, int jobs, int threads,
    const std::function<void(const SweepTask& task, std::size_t ended, const std::string& what)>& on_end);

}  // namespace splinevox::run
