// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "core/atomic_file.hpp"
#include "core/process.hpp"
#include "io/manifest.hpp"
#include "run/effects_report.hpp"
#include "run/join_ranks.hpp"
#include "run/signals.hpp"
#include "run/support.hpp"
#include "run/train_options.hpp"
#include "run/train_session.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

/// The dataset as it was when the run began: another one cannot be gone on with.
void check_same_run(const RunFolder& folder, const Config& saved, const Config& asked,
                    const RunRecord& record, const Dataset& data) {
  const std::string differs = config_difference(saved, asked);
  if (!differs.empty())
    fail({folder.file("config.toml"),
          "the run was made with another configuration, so it cannot be resumed with this one",
          "the same settings", differs,
          "splinevox train DATASET --out RUN --resume  (it knows its own settings), or another --out"});
  if (record.fingerprint != data.fingerprint)
    fail({folder.file("config.toml"), "the run was made from other training data", record.dataset,
          fmt::format("{} (fingerprint {:016x}, the run has {:016x})", data.path, data.fingerprint,
                      record.fingerprint),
          "another folder for --out"});
}

void greet(const Dataset& data, const Config& c, Device device, Progress& progress) {
  const Split& train = *data.find("train");
  const Picture& first = train.frames.front().image;
  for (const std::string& note : data.notes) progress.note("note: " + note);
  const std::string length =
      c.run.max_time > 0 ? duration(c.run.max_time) : fmt::format("{} steps", c.run.max_steps);
  progress.note(fmt::format("{}: {} training views of {}x{}, preset {}, {}, {} threads, {}", data.path,
                            train.frames.size(), first.width, first.height, c.preset, length,
                            tbb::this_task_arena::max_concurrency(), describe(device)));
}

/// Pictures without alpha have no silhouettes to find the scene by; where the data says how far it reaches,
/// that is the box.
void settle_bounds(Config& config, const Dataset& data, Progress& progress) {
  if (data.has_alpha || !data.box || !config.grid.box.empty()) return;
  const Box& b = *data.box;
  config.grid.box = {b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z};
  progress.note(fmt::format(
      "opaque pictures: the box is the data's own, {:.4g} x {:.4g} x {:.4g} (--set grid.box=... for another)",
      b.extent().x, b.extent().y, b.extent().z));
}

/// Tries out which effects the scene calls for and writes effects.json. What the user listed is measured, not
/// changed.
void settle_effects(Config& config, bool forced, const Dataset& data, const RunFolder& folder, bool writes,
                    Progress& progress) {
  if (config.effects.steps > 0) progress.note("trying out which effects the scene calls for");
  const EffectChoice choice =
      choose_effects(config, *data.find("train"), data.time_map, [&](const EffectTrial& t) {
        progress.note(fmt::format("  {:<32} {:.2f} dB on held-out pictures after {} steps, {:.1f} s",
                                  to_string(t.effects), t.mean(), t.steps, t.seconds));
      });
  release_freed_memory();  // of the fits
  if (!forced) apply(choice.chosen, config), config.motion.points = choice.points;
  EffectSet used = effects_of(config);
  if (data.has_alpha) used = used.without(Effect::background);  // nothing is behind what such pictures show
  const Json effects = effects_json(choice, config, used, forced);
  progress.note(effects_line(effects));
  if (!writes) return;
  write_file(folder.file(kEffects), {json_text(effects, 2) + "\n"});
}

void summarise(const Json& j, const RunFolder& folder) {
  const double train = j["train_seconds"];
  fmt::print("{} steps in {:.1f} s; {:.2f} million rays/s, {:.2f} million samples/s\n",
             j["steps"].get<std::int64_t>(), train, j["rays_per_second"].get<double>() / 1e6,
             j["samples_per_second"].get<double>() / 1e6);
  fmt::print("seconds:");
  for (const auto& [name, seconds] : j["phases"].items())
    fmt::print(" {} {:.1f}", name, seconds.get<double>());
  fmt::print(", held view {:.1f}, loading {:.1f}, saving {:.1f}\n", j["held_view_seconds"].get<double>(),
             j["load_seconds"].get<double>(), j["save_seconds"].get<double>());
  fmt::print("peak memory {:.2f} GB\n", j["peak_memory_bytes"].get<double>() / 1e9);
  if (j.contains("held"))
    fmt::print("{} {}: PSNR {:.2f} dB\n",
               j["held"]["of_training_split"].get<bool>() ? "training view" : "held view",
               j["held"]["view"].get<std::string>(), j["held"]["psnr"].get<double>());
  fmt::print("model: {}\n", folder.file("model.vdb"));
}

/// Whether a run has had its budget and saved what came of it.
bool has_ended(const RunFolder& folder) {
  if (!folder.has("metrics.json") || !folder.has("model.vdb")) return false;
  const Json metrics = read_json(folder.file("metrics.json"));
  return metrics.is_object() && metrics.value("finished", false);
}

/// Leaves such a run as it is, with what `eval` wrote about it.
int leave(const RunFolder& folder, Progress& progress) {
  progress.note(fmt::format("{} is finished: there is nothing to go on with", folder.path()));
  if (progress.talk() == Talk::json) fmt::print("{}\n", json_text(read_json(folder.file("metrics.json"))));
  return 0;
}

int train(const TrainOptions& o, std::chrono::steady_clock::time_point start) {
  const std::unique_ptr<Ranks> ranks = join_ranks("train");
  const Device device = ranks ? choose_device(o.device, *ranks) : choose_device(o.device);
  std::unique_ptr<StepBackend> steps =
      device == Device::cpu ? nullptr
                            : make_step(device, o.deterministic, ranks.get());  // what it lacks is told first
  const bool writes = !ranks || ranks->first();
  Progress progress(writes ? choose_talk(o.quiet, o.json) : Talk::quiet);
  const RunFolder folder = writes ? RunFolder(o.out, o.resume) : RunFolder::of_other(o.out);
  if (folder.has(kEditHistory))
    fail(
        {folder.path(), "this run was made by `splinevox edit`: there is no training in it to go on with",
         "a run that `splinevox train` made", "an edited run",
         "--resume the run it was made from (" + std::string(kEditHistory) + " names it), or another --out"});
  bool checkpoint = o.resume && folder.has("config.toml") &&
                    (folder.has(kCheckpoint) || folder.has(std::string(kCheckpoint) + ".prev"));
  if (ranks) checkpoint = ranks->from_first(checkpoint) != 0;
  const bool known = o.resume && folder.has("config.toml");
  Config saved;  // as it trains
  RunRecord record;
  if (known) read_run_config(folder.path(), saved, record);
  Config before = saved;  // as it was asked for
  if (known && folder.has(kAskedConfig)) read_config(before, folder.file(kAskedConfig));
  const Config asked = effective_config(o, known ? &before : nullptr);
  Config config = checkpoint ? saved : asked;
  bool finished = known && has_ended(folder);
  if (ranks) finished = ranks->from_first(finished) != 0;
  if (o.resume && !checkpoint && !finished) {
    const std::string afresh = fmt::format("there is no checkpoint in {}: starting afresh", folder.path());
    if (progress.talk() == Talk::json) fmt::print("{}\n", json_text({{"note", afresh}}));
    progress.note(afresh);
  }

  LoadOptions load;
  load.downscale = config.run.downscale;
  load.splits = {"train"}, load.if_there = {"val"};
  const Dataset data = load_dataset(o.dataset, load);
  if (checkpoint || finished) check_same_run(folder, before, asked, record, data);
  if (finished) return leave(folder, progress);
  greet(data, config, device, progress);
  if (!checkpoint) {
    settle_bounds(config, data, progress);
    settle_effects(config, o.effects != "auto", data, folder, writes, progress);
    record = {kVersion, SPLINEVOX_COMPILER, fs::absolute(o.dataset).lexically_normal().string(),
              data.fingerprint, data.time_map};
    if (writes) {
      std::error_code ignored;
      for (const char* name : {"metrics.json", kManifestName, kAskedConfig})
        fs::remove(folder.file(name), ignored);  // of a run whose checkpoint is gone
      if (!config_difference(asked, config).empty())
        write_file(folder.file(kAskedConfig), {write_config(asked)});
      write_file(folder.file("config.toml"), {write_config(config) + record_text(record)});
      write_file(folder.file("metrics.jsonl"), {std::string()});
    }
  }
  const double used = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  TrainSession session({config, data, folder, used, checkpoint, ranks.get(), device, std::move(steps)},
                       progress);
  Json figures = session.run();
  if (!writes) return session.interrupted() ? kInterrupted : 0;
  figures["threads"] = tbb::this_task_arena::max_concurrency();
  figures["device"] = describe(device);
  if (!figures["finished"].get<bool>()) {
    if (progress.talk() == Talk::json)
      fmt::print("{}\n", json_text({{"interrupted", true}, {"step", figures["steps"]}}));
    progress.note(fmt::format("interrupted at step {}; checkpoint and model are saved, go on with --resume",
                              figures["steps"].get<std::int64_t>()));
    write_file(folder.file("metrics.json"), {json_text(figures, 2) + "\n"});
    return kInterrupted;
  }
  write_file(folder.file("metrics.json"), {json_text(figures, 2) + "\n"});
  if (progress.talk() == Talk::json) fmt::print("{}\n", json_text(figures));
  if (progress.talk() == Talk::bar || progress.talk() == Talk::lines) summarise(figures, folder);
  return 0;
}

}  // namespace

Action train_command(CLI::App& verb) {
  auto options = std::make_shared<TrainOptions>();
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
    catch_stop_signals();
    return with_threads(options->threads, [&] { return train(*options, start); });
  };
}

}  // namespace splinevox::cli
