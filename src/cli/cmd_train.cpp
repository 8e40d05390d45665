// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>

#include "cli/command.hpp"
#include "cli/join_ranks.hpp"
#include "cli/options.hpp"
#include "run/memory_needs.hpp"
#include "run/signals.hpp"
#include "run/support.hpp"
#include "run/train.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cli {
namespace {

void summarise(const Json& j, const std::string& run) {
  const double train = j["train_seconds"];
  fmt::print("{} steps in {:.1f} s; {:.2f} million rays/s, {:.2f} million samples/s\n",
             j["steps"].get<std::int64_t>(), train, j["rays_per_second"].get<double>() / 1e6,
             j["samples_per_second"].get<double>() / 1e6);
  fmt::print("seconds:");
  for (const auto& [name, seconds] : j["phases"].items())
    fmt::print(" {} {:.1f}", name, seconds.get<double>());
  fmt::print(", held-out view {:.1f}, loading {:.1f}, saving {:.1f}\n", j["held_view_seconds"].get<double>(),
             j["load_seconds"].get<double>(), j["save_seconds"].get<double>());
  fmt::print("peak memory {:.2f} GB\n", j["peak_memory_bytes"].get<double>() / 1e9);
  if (j.contains("held"))
    fmt::print("{} {}: PSNR {:.2f} dB\n",
               j["held"]["of_training_split"].get<bool>() ? "training view" : "held-out view",
               j["held"]["view"].get<std::string>(), j["held"]["psnr"].get<double>());
  fmt::print("model: {}/model.vdb\n", run);
}

int train(const TrainVerb& o, std::chrono::steady_clock::time_point start) {
  const std::unique_ptr<Ranks> ranks = join_ranks("train");
  Progress progress(!ranks || ranks->first() ? choose_talk(o.quiet, o.json) : Talk::quiet);
  const bool json = progress.talk() == Talk::json, quiet = progress.talk() == Talk::quiet;
  const TrainedRun run = run::train(o, ranks.get(), progress, start);
  const bool interrupted = run.end == TrainedRun::End::interrupted;
  if (run.writes && interrupted) {
    const std::int64_t step = run.figures["steps"];
    if (json) fmt::print("{}\n", json_text({{"interrupted", true}, {"step", step}}));
    progress.note(
        fmt::format("interrupted at step {}; checkpoint and model are saved, go on with --resume", step));
  } else if (json) {
    fmt::print("{}\n", json_text(run.figures));
  } else if (!quiet && run.end == TrainedRun::End::finished) {
    summarise(run.figures, run.folder);
  }
  return interrupted ? kInterrupted : 0;
}

}  // namespace

Action train_command(CLI::App& verb) {
  auto options = std::make_shared<TrainVerb>();
  add_train_options(verb, *options);
  return [options] {
    const auto start = std::chrono::steady_clock::now();
    if (options->list_settings) {
      fmt::print("{}", write_config(effective_config(*options, nullptr)));
      return 0;
    }
    for (const auto& [value, name] : {std::pair{options->dataset, "DATASET"}, {options->out, "--out"}})
      if (value.empty())
        fail({"train", fmt::format("{} is missing", name), "splinevox train DATASET --out RUN", "",
              "splinevox train --help"});
    if (!options->resume)
      effective_config(*options, nullptr);  // wrong settings are found before anything is touched
    memory_bound(options->memory);
    catch_stop_signals();
    return with_threads(options->threads, [&] { return train(*options, start); });
  };
}

}  // namespace splinevox::cli
