// SPDX-License-Identifier: Apache-2.0
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <utility>

#include "cli/command.hpp"
#include "cli/join_ranks.hpp"
#include "cli/options.hpp"
#include "core/number_text.hpp"
#include "live/live_page.hpp"
#include "run/events.hpp"
#include "run/memory_needs.hpp"
#include "run/signals.hpp"
#include "run/support.hpp"
#include "run/train.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

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
    fmt::print("{} view {}{}: PSNR {:.2f} dB\n", j["held"]["split"].get<std::string>(),
               j["held"]["view"].get<std::string>(),
               j["held"]["of_training_split"].get<bool>() ? "" : ", held out",
               j["held"]["psnr"].get<double>());
  fmt::print("model: {}/model.vdb\n", run);
}

/// A folder for a run that nobody named: runs/NAME-DATE, of the data set and of now. Not there yet.
std::string free_run_folder(const std::string& dataset) {
  const std::time_t now = std::time(nullptr);
  const std::string name = fmt::format("runs/{}-{:%Y%m%d-%H%M%S}", folder_name(dataset), fmt::localtime(now));
  std::string out = name;
  for (int i = 2; fs::exists(fs::symlink_status(out)); ++i) out = fmt::format("{}-{}", name, i);
  return out;
}

/// What train cannot do without: the data set, and the run to go on with, or a place for a new one.
void complete(TrainVerb& o) {
  const bool word = o.live && o.live->find_first_not_of("0123456789") != std::string::npos;
  if (word && o.dataset.empty() && fs::exists(*o.live)) o.dataset = std::exchange(*o.live, "");
  const auto missing = [](const char* name, const char* hint) {
    fail({"train", fmt::format("{} is missing", name), "splinevox train DATASET --out RUN", "", hint});
  };
  if (o.dataset.empty()) missing("DATASET", "splinevox train --help");
  if (!o.out.empty()) return;
  if (o.resume) missing("--out", "the folder of the run to go on with");
  o.out = free_run_folder(o.dataset);
  o.named = false;
}

/// A word behind --live as a port; 0: a free one.
int port_of(const std::string& word) {
  if (word.empty()) return 0;
  const int port = parse_number<int>(word).value_or(0);
  if (port <= 0 || port >= 65536)
    fail({"--live", "this is no port", "a number from 1 to 65535, or nothing: then a free one is taken", word,
          "splinevox train DATASET --out RUN --live"});
  return port;
}

/// The page of --live. Its address is what one asked for, so it is said however quiet the rest is.
std::unique_ptr<LivePage> open_page(const TrainVerb& o, const Ranks* ranks) {
  if (!o.live) return nullptr;
  if (ranks) fail({"--live", "the page is for a training in one process", "", "several under mpirun", ""});
  auto page = std::make_unique<LivePage>(port_of(*o.live), folder_name(o.out));
  if (o.json)
    write_event("live", {{"live", page->address()}});
  else
    fmt::print(stderr, "live page: {}\n", page->address());
  std::fflush(nullptr);
  return page;
}

int train(const TrainVerb& o, const Timer& since_start) {
  const std::unique_ptr<Ranks> ranks = join_ranks("train");
  const std::unique_ptr<LivePage> page = open_page(o, ranks.get());
  TrainEvents events;
  if (page) events.note = [&](const std::string& text) { page->note(text); };
  Progress progress(!ranks || ranks->first() ? choose_talk(o.quiet, o.json) : Talk::quiet, events);
  if (!o.named) {
    if (ranks) fail({"train", "--out is missing", "one folder for all processes", "", "--out RUN"});
    progress.note("run: " + o.out);
  }
  const bool json = progress.talk() == Talk::json, quiet = progress.talk() == Talk::quiet;
  const TrainedRun run = run::train(o, ranks.get(), progress, since_start, page.get());
  const bool interrupted = run.end == TrainedRun::End::interrupted;
  if (run.writes && interrupted) {
    const std::int64_t step = run.figures.value("steps", std::int64_t(0));
    progress.note(
        run.figures.empty()
            ? "interrupted before the first step; nothing is saved"
            : fmt::format("interrupted at step {}; checkpoint and model are saved, go on with --resume",
                          step));
    progress.event("interrupted", {{"interrupted", true}, {"step", step}});  // the last line
  } else if (json) {
    write_event("result", run.figures);
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
    const Timer since_start;
    if (options->list_settings) {
      const std::string settings = write_config(effective_config(*options, nullptr));
      if (options->json)
        write_event("result", {{"settings", settings}});
      else
        fmt::print("{}", settings);
      return 0;
    }
    complete(*options);
    if (!options->resume)
      effective_config(*options, nullptr);  // wrong settings are found before anything is touched
    memory_bound(options->memory);
    catch_stop_signals();
    return with_threads(options->threads, [&] { return train(*options, since_start); });
  };
}

}  // namespace splinevox::cli
