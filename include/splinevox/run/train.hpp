// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/train/config.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox::run {

/// A training run as `splinevox train` is asked for it.
struct TrainOptions {
  std::string dataset;                    ///< folder of a data set
  std::string out;                        ///< folder of the run: free, or one to go on with
  std::string config_file;                ///< TOML over the preset; empty: none
  std::string device = "auto";            ///< see choose_device
  std::string effects = "auto";           ///< those the scene calls for; "all"; or a list of effect_names()
  std::optional<std::string> preset;      ///< absent: that of the run to go on with, or "fast"
  std::optional<std::string> background;  ///< "white", "black" or "R,G,B" in 0..1
  DatasetRules rules;                     ///< how the data set is understood; a file of times by any path
  std::vector<std::string> sets;          ///< "group.key=value", over the file
  std::optional<double> max_time;         ///< seconds, loading included
  std::optional<int> max_steps;           ///< alone, the same seed gives the same bits
  std::optional<int> downscale;
  std::optional<std::uint64_t> seed;
  std::string memory;  ///< most the process may take, as "6G"; empty: what the machine or container leaves it
  std::string cache;   ///< folder for pictures that do not fit into it; empty: LoadOptions::cache
  bool resume = false;         ///< go on with the run in `out`, or begin it if it has no checkpoint
  bool deterministic = false;  ///< on a device too: the same bits in every run
  std::string commit;          ///< of the program, to be kept with the figures; empty: nobody knows
};

/// The effective configuration: preset (or, when a run is resumed, the one it has), then the TOML file, then
/// `sets`, then the named options. Validated. Throws Error (input) naming the option of the command line.
/// @param resumed  the configuration of the run to go on with; null: none
Config effective_config(const TrainOptions& options, const Config* resumed = nullptr);

/// Who hears a training run. Any may be empty.
struct TrainEvents {
  std::function<void(const std::string&)> note = {};  ///< a line to show
  /// Every step. False: stop, with everything saved, as after a signal.
  std::function<bool(const StepReport&)> step = {};
};

/// What became of a training run.
struct TrainEnd {
  bool finished = false;  ///< its budget is spent; false: it was stopped, and `resume` goes on with it
  std::int64_t steps = 0;
  double seconds = 0;   ///< of the budget
  std::string figures;  ///< RUN/metrics.json, the text
};

/// Trains into a run folder as `splinevox train` does: loads the data, prepares the configuration
/// (train/prepare.hpp), trains, saves checkpoints on the way and model.vdb, metrics.json and the manifest at
/// the end. A run that is finished already is left as it is. On the calling arena's threads, or on a device.
/// Throws Error: input for wrong options or data, output for what cannot be written, numeric after steps in a
/// row that were not finite.
TrainEnd train(const TrainOptions& options, const TrainEvents& events = {});

}  // namespace splinevox::run
