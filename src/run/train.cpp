// SPDX-License-Identifier: Apache-2.0
#include "run/train.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/hash.hpp"
#include "core/process.hpp"
#include "data/times/settle.hpp"
#include "io/manifest.hpp"
#include "run/effects_report.hpp"
#include "run/made_with.hpp"
#include "run/memory_needs.hpp"
#include "run/own_json.hpp"
#include "run/signals.hpp"
#include "run/train_session.hpp"
#include "run/training_pictures.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/train/prepare.hpp"
#include "train/learn_depth.hpp"
#include "train/learn_tracks.hpp"
#include "train/paced.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

/// Gradients of different pictures, or of models of different shapes, must not be added up. All ranks throw.
void check_ranks_agree(Ranks& ranks, const Dataset& data, const Config& config) {
  const std::uint64_t facts[] = {data.fingerprint, hash64(write_config(config))};
  std::vector<double> mine;  // halves of 32 bits, which doubles hold
  for (const std::uint64_t fact : facts)
    mine.insert(mine.end(), {double(fact & 0xffffffff), double(fact >> 32)});
  const std::vector<double> all = ranks.gather(mine);
  for (int rank = 1; rank < ranks.count(); ++rank)
    for (std::size_t i = 0; i < mine.size(); ++i)
      if (all[std::size_t(rank) * mine.size() + i] != all[i])
        fail({fmt::format("process {} of {}", rank + 1, ranks.count()),
              i < 2 ? "has other training pictures than the first"
                    : "has settled on other settings than the first",
              "the same data set, words and build of the program on every machine", "", ""});
}

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

/// The rules asked for, else those of the run to go on with. A file of times gets its full path: later verbs
/// may be called from elsewhere.
DatasetRules rules_of(const TrainOptions& o, const RunRecord& record) {
  DatasetRules rules = record.rules;
  each_rule(
      [](const char*, std::string& rule, const std::string& asked) {
        if (!asked.empty()) rule = asked;
      },
      rules, o.rules);
  if (data::parse_times(rules.times).source == data::TimesChoice::Source::file)
    rules.times = whole_path(rules.times).string();
  if (!rules.tracks.empty() && rules.tracks != "none") rules.tracks = whole_path(rules.tracks).string();
  return rules;
}

void greet(const Dataset& data, const Config& c, Device device, Progress& progress) {
  const Split& train = *data.find("train");
  const Picture& first = train.frames.front().image;
  for (const std::string& note : data.notes) progress.note("note: " + note);
  std::string length = c.run.max_time > 0 ? duration(c.run.max_time) : "";
  if (c.run.max_steps > 0) length += fmt::format("{}{} steps", length.empty() ? "" : " or ", c.run.max_steps);
  progress.note(fmt::format("{}: {} training views of {}x{}, preset {}, {}, {} threads, {}", data.path,
                            train.frames.size(), first.width, first.height, c.preset, length,
                            tbb::this_task_arena::max_concurrency(), describe(device)));
}

/// Thrown where somebody asked to stop before the first step.
struct StoppedEarly {};

/// Makes the configuration ready for the data. What the user listed is measured, not changed.
/// @param alone  no others must settle on the same. @param used  seconds of the budget that are gone. Throws
/// StoppedEarly, after a fit; others would wait for one that stopped
Prepared settle(const Config& asked, bool forced, Dataset& data, bool alone, double used,
                const Watcher* watcher, Progress& progress) {
  PrepareOptions options;
  options.by_clock = alone;
  options.used = used;
  options.effects = forced ? EffectPolicy::measure : EffectPolicy::choose;
  options.on_note = [&](const std::string& text) { progress.note(text); };
  const auto obey = [&] {
    if (alone && (stop_asked() || (watcher && watcher->stop_wished()))) throw StoppedEarly{};
  };
  options.on_trial = [&](const EffectTrial& t) {
    progress.note(fmt::format("  {:<39} {:.2f} dB held-out, {} steps, {:.1f} s", to_string(t.effects),
                              t.mean(), t.steps, t.seconds));
    obey();
  };
  options.on_film = [&](const FilmEvidence& f) {
    progress.note(
        fmt::format("  {:<39} {:.2f} dB in the film's pictures, but for {:.2f}% of their pixels; {:.1f} s",
                    "a still world", f.psnr, 100 * f.share, f.seconds));
    obey();
  };
  Prepared prepared = prepare(asked, data, options);
  const Json effects = effects_json(prepared);
  progress.event("effects", effects);
  for (const std::string& line : effects_lines(effects)) progress.note(line);
  return prepared;
}

/// A budget of seconds in which no step was made leaves nothing worth a model.
/// @param used  seconds of it that are gone. @param by  what took them
void check_time_left(const RunConfig& run, double used, const char* by) {
  if (run.max_time <= 0 || used < run.max_time) return;
  constexpr double kEnough = 4;  // times what was used
  fail({"--max-time",
        fmt::format("{} took {:.3g} of {:.3g} seconds: none are left to train", by, used, run.max_time),
        "a longer time", "",
        fmt::format("--max-time {:.0f}, or smaller pictures: --downscale {}", std::ceil(kEnough * used),
                    2 * run.downscale)});
}

/// A budget of seconds that gave far fewer steps than the preset was measured with: large or many pictures,
/// or a slow machine. What more seconds would give is not to be guessed from the result.
void note_few_steps(const Config& config, const Json& figures, Progress& progress) {
  constexpr double kFew = 0.25;
  if (!by_clock(config.run) || !figures.contains("preset_share")) return;
  const double share = figures["preset_share"];
  if (share >= kFew) return;
  progress.note(fmt::format(
      "note: {:.0f} seconds gave {} steps, {:.2g}% of the {} that preset {} was measured with; go on "
      "with --resume --max-time {:.0f}, or train anew with --downscale {} or more cores",
      config.run.max_time, figures["steps"].get<std::int64_t>(), 100 * share,
      figures["preset_steps"].get<int>(), config.preset,
      std::ceil(config.run.max_time / std::max(share, 1e-4)), 2 * config.run.downscale));
}

/// Whether a run is asked to go on for longer than it was made for.
bool is_longer(const RunConfig& before, const RunConfig& asked) {
  return by_clock(before) && by_clock(asked) && asked.max_time > before.max_time;
}

/// Whether a run has had its budget and saved what came of it.
bool has_ended(const RunFolder& folder) {
  if (!folder.has("metrics.json") || !folder.has("model.vdb")) return false;
  return read_metrics(folder.file("metrics.json")).value("finished", false);
}

/// What a folder holds of an earlier call, and what is to be done with it.
struct Continuation {
  bool checkpoint = false;  ///< there is a run to go on with from where it stopped
  bool longer = false;      ///< one to go on with for more seconds than it was made for
  bool finished = false;    ///< there is nothing to go on with
  bool forced = false;      ///< its effects were listed, now or then
  Config before;            ///< as it was asked for then
  Config asked;             ///< as it is asked for now
  Config config;            ///< as it trains; without a checkpoint `asked`, until that is settled
  RunRecord record;         ///< of the run to go on with
};

/// The same on all ranks. Throws Error (input) for the folder of an edited run.
Continuation find_continuation(const TrainOptions& o, const RunFolder& folder, Ranks* ranks) {
  if (folder.has(kEditHistory))
    fail(
        {folder.path(), "this run was made by `splinevox edit`: there is no training in it to go on with",
         "a run that `splinevox train` made", "an edited run",
         "--resume the run it was made from (" + std::string(kEditHistory) + " names it), or another --out"});
  Continuation out;
  const bool known = o.resume && folder.has("config.toml");
  out.checkpoint = known && (folder.has(kCheckpoint) || folder.has(std::string(kCheckpoint) + ".prev"));
  if (ranks) out.checkpoint = ranks->from_first(out.checkpoint) != 0;
  Config saved;
  if (known) read_run_config(folder.path(), saved, out.record);
  out.before = saved;
  if (known && folder.has(kAskedConfig)) read_config(out.before, folder.file(kAskedConfig));
  out.asked = effective_config(o, known ? &out.before : nullptr);
  // Where more time was given on the live page, the run may be asked for by the time it had before or has
  // now.
  if (known && out.asked.run.max_time == saved.run.max_time) out.before.run.max_time = saved.run.max_time;
  out.longer = known && is_longer(saved.run, out.asked.run);
  if (out.longer) out.before.run.max_time = saved.run.max_time = out.asked.run.max_time;
  out.config = out.checkpoint ? saved : out.asked;
  const Json effects = known ? read_effects_if_there(folder.file(kEffects)) : Json();
  out.forced = o.effects != "auto" || (effects.is_object() && effects.value("forced", false));
  out.finished = known && has_ended(folder) && !out.longer;
  if (ranks) out.finished = ranks->from_first(out.finished) != 0;
  return out;
}

/// Who made the figures, when and on what.
void sign(Json& figures, Device device) {
  figures["threads"] = tbb::this_task_arena::max_concurrency();
  figures["device"] = describe(device);
  figures["date"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  figures["splinevox"] = kVersion;
  for (const auto& [key, text] : {std::pair{"commit", source_commit()}, std::pair{"command", command_line()},
                                  std::pair{"machine", machine_name()}})
    if (!text.empty()) figures[key] = text;
}

}  // namespace

TrainedRun train(const TrainOptions& o, Ranks* ranks, Progress& progress, const Timer& since_start,
                 Watcher* watcher) {
  Device device = ranks ? choose_device(o.device, *ranks) : choose_device(o.device);
  std::unique_ptr<StepBackend> steps =
      make_step(device, o.deterministic, ranks);  // so that a lacking device fails first
  const bool writes = !ranks || ranks->first();
  const RunFolder folder = writes ? RunFolder(o.out, o.resume) : RunFolder::of_other(o.out);
  Continuation past = find_continuation(o, folder, ranks);
  Config &asked = past.asked, &config = past.config;
  RunRecord& record = past.record;
  if (o.resume && !past.checkpoint && !past.finished)
    progress.note(fmt::format("there is no checkpoint in {}: starting afresh", folder.path()));

  LoadOptions load;
  load.downscale = config.run.downscale;
  load.splits = {"train"};
  load.if_there = {"val"};
  load.rules = rules_of(o, record);
  load.depth = config.loss.depth > 0;
  load.tracks = config.loss.tracks > 0;
  load.cache = o.cache;
  const double bound = memory_bound(o.memory);
  MemoryNeeds needs;
  load.room = [&](const Dataset& frames) {
    needs = memory_needs(config, frames);
    return room_for_pictures(bound, needs);
  };
  Dataset data = load_dataset(o.dataset, load);
  const Split& split = *data.find("train");
  if (o.device == "auto" &&
      (leaves_out_depth(*steps, config, split) || leaves_out_tracks(*steps, config, split))) {
    device = Device::cpu;
    steps = make_step(device, o.deterministic, ranks);
    progress.note("depth and tracks are learned on the CPU alone: --device auto takes it");
  }
  check_learns_depth(*steps, config, split);
  check_learns_tracks(*steps, config, split);
  if (past.checkpoint || past.finished) check_same_run(folder, past.before, asked, record, data);
  if (past.finished) {
    progress.note(fmt::format("{} is finished: there is nothing to go on with", folder.path()));
    const Json figures = writes ? read_metrics(folder.file("metrics.json")) : Json::object();
    return {folder.path(), figures, TrainedRun::End::was_finished, writes};
  }
  greet(data, config, device, progress);
  progress.note(memory_line(bound, needs, data));
  std::string effects;  // of a run that begins, for its file
  const std::string dataset = whole_path(o.dataset).string(), before = record_text(record);
  if (past.checkpoint) {
    cut_ground(config, data);
    record.dataset = dataset;  // it may have moved
    record.rules = load.rules;
  } else {
    try {
      const auto used_by = [&](const char* what) {
        const double used = ranks ? ranks->from_first(since_start.seconds()) : since_start.seconds();
        check_time_left(asked.run, used, what);
        return used;
      };
      const double loading = used_by("loading");
      const Prepared ready = settle(asked, past.forced, data, !ranks, loading, watcher, progress);
      used_by("loading and trials");
      config = ready.config;
      // More control points than were asked for need more: a run that could not be resumed must not begin.
      if (const MemoryNeeds settled = memory_needs(config, data); settled.lattices > needs.lattices) {
        const double room = room_for_pictures(bound, settled);
        if (data.pictures_in_memory > room)
          fail({"--memory",
                "the control points that were found need more of it than is left beside the pictures",
                fmt::format("pictures of at most {:.2f} GB", 1e-9 * room),
                fmt::format("{:.2f} GB", 1e-9 * data.pictures_in_memory),
                fmt::format("--set motion.points={}, or more --memory", asked.motion.points)});
        progress.note(memory_line(bound, settled, data));
      }
      effects = json_text(effects_json(ready), 2) + "\n";
      record = {kVersion,      SPLINEVOX_COMPILER, dataset,       data.fingerprint,
                data.time_map, load.rules,         ready.parallax};
    } catch (const StoppedEarly&) {
      return {folder.path(), Json::object(), TrainedRun::End::interrupted, writes};
    }
  }
  if (ranks) check_ranks_agree(*ranks, data, config);
  const double used = since_start.seconds();
  const auto write_settings = [&] {
    if (!config_difference(asked, config).empty())
      write_file(folder.file(kAskedConfig), {write_config(asked)});
    write_file(folder.file("config.toml"), {write_config(config) + record_text(record)});
  };
  const auto lengthen = [&](double seconds) {
    config.run.max_time += seconds;  // `asked` stays: the same command is to go on
    write_settings();
    return config.run.max_time;
  };
  TrainSession session(
      {config, data, folder, used, past.checkpoint, ranks, device, std::move(steps), watcher, lengthen},
      progress);
  if (!past.checkpoint) check_time_left(config.run, session.seconds(), "loading and preparing");
  if (writes && !effects.empty()) write_file(folder.file(kEffects), {effects});
  if (writes)  // also where a run of an older version goes on, which has none
    write_file(folder.file(kTrainingPictures), {training_pictures_text(*data.find("train"))});
  if (writes && (!past.checkpoint || past.longer)) {  // whoever cannot begin leaves nothing behind
    std::error_code ignored;
    for (const char* name : {"metrics.json", kManifestName, kAskedConfig})
      fs::remove(folder.file(name), ignored);  // of a run whose checkpoint is gone, or that had ended
    write_settings();
    if (!past.checkpoint) write_file(folder.file("metrics.jsonl"), {std::string()});
  }
  if (writes && past.checkpoint && !past.longer && record_text(record) != before) write_settings();
  if (writes)  // `eval` measured the model that was there
    for (const char* name : {"metrics_val.json", "metrics_train.json"}) {
      std::error_code ignored;
      fs::remove(folder.file(name), ignored);
    }
  Json figures = session.run();
  const auto end = session.interrupted() ? TrainedRun::End::interrupted : TrainedRun::End::finished;
  if (!writes) return {folder.path(), Json::object(), end, writes};
  if (end == TrainedRun::End::finished) note_few_steps(config, figures, progress);
  sign(figures, device);
  write_file(folder.file("metrics.json"), {json_text(figures, 2) + "\n"});
  return {folder.path(), std::move(figures), end, writes};
}

TrainEnd train(const TrainOptions& options, const TrainEvents& events) {
  const Timer since_start;
  Progress progress(Talk::quiet, events);
  const TrainedRun run = train(options, nullptr, progress, since_start);
  return {run.end != TrainedRun::End::interrupted, run.figures.value("steps", std::int64_t(0)),
          run.figures.value("train_seconds", 0.0), json_text(run.figures, 2) + "\n"};
}

}  // namespace splinevox::run
