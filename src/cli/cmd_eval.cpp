// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "cli/eval_pictures.hpp"
#include "cli/options.hpp"
#include "cli/scores_print.hpp"
#include "core/atomic_file.hpp"
#include "core/system.hpp"
#include "run/correspondence.hpp"
#include "run/folder_lock.hpp"
#include "run/folder_mark.hpp"
#include "run/held_camera.hpp"
#include "run/outer_metric.hpp"
#include "run/own_json.hpp"
#include "run/scores_json.hpp"
#include "run/standard_output.hpp"
#include "run/support.hpp"
#include "run/teller.hpp"
#include "run/volume_score.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"
#include "train/check_cameras.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

constexpr FolderMark kPicturesMark{"eval.json", "splinevox eval pictures"};  ///< in a folder of --images

/// Makes a folder for pictures ours. One that holds anything else, as a data set's does, is refused: frames
/// have the names of their pictures.
void claim_pictures(const std::string& folder, const Run& run, const std::string& split) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored) && !fs::is_empty(folder) && !has_mark(folder, kPicturesMark))
    fail({folder, "this folder holds files that `eval --images` did not write",
          "an empty folder, a name that is free, or the pictures of an earlier eval", "",
          "another folder for --images"});
  probe_output_folder(folder);
  write_mark(folder, kPicturesMark, {{"run", run.path}, {"split", split}});
}

/// Whether figures are of the pictures that the run is about. Where its own data set is no longer there, what
/// is given for it is that.
bool own_pictures(const Run& run, const std::string& data) {
  std::error_code ignored;
  return data.empty() || !fs::exists(run.record.dataset, ignored) ||
         fs::equivalent(data, run.record.dataset, ignored);
}

/// Whether a file is one in which a run keeps figures.
bool of_run(const fs::path& file) {
  std::error_code ignored;
  const std::string name = file.filename().string();
  const bool figures = name == "metrics.json" || name == "metrics_train.json" || name == "metrics_val.json" ||
                       name == "metrics.jsonl";
  return figures && fs::exists(file.parent_path() / "config.toml", ignored);
}

/// Which file model.vdb is: one that replaces it is another.
struct ModelFile {
  explicit ModelFile(const std::string& run) { there = ::stat((run + "/model.vdb").c_str(), &info) == 0; }
  bool operator==(const ModelFile& o) const {
    return there && o.there && info.st_dev == o.info.st_dev && info.st_ino == o.info.st_ino &&
           info.st_size == o.info.st_size && changed_at(info).tv_sec == changed_at(o.info).tv_sec &&
           changed_at(info).tv_nsec == changed_at(o.info).tv_nsec;
  }
  bool there = false;
  struct stat info {};
};

[[noreturn]] void fail_kept(const Run& run, const std::string& got) {
  fail_output({run.path, "the figures are not kept in the run", "the model that they are of", got,
               "eval again when training has ended"});
}

/// The right to write into the run, beside other evals but not beside a training.
FolderLock lock_of(const Run& run) {
  try {
    return FolderLock(run.path, "training into", false);
  } catch (const Error& e) {
    fail_kept(run, e.problem.what);
  }
}

/// The figures of a split into the run: those of the test split join what training left in metrics.json,
/// others get a file of their own.
void save(const Run& run, const ModelFile& read, const Json& result) {
  const FolderLock lock = lock_of(run);
  if (!(ModelFile(run.path) == read)) fail_kept(run, "another model.vdb has taken its place");
  const std::string split = result["split"];
  std::string path = run.path + "/metrics.json";
  Json metrics = Json::object();
  if (split != "test")
    path = fmt::format("{}/metrics_{}.json", run.path, split);
  else
    metrics = read_metrics_if_there(path);
  for (const char* key :
       {"psnr_inside", "inside_views", "inside_share", "ignored_share", "metrics", kHeldCamera})
    metrics.erase(key);  // of masks, a film or a command, that may no longer be there
  Json merged = result;  // the figures of interest first
  for (const auto& [key, value] : metrics.items())
    if (!merged.contains(key)) merged[key] = value;
  write_file(path, {json_text(merged, 2) + "\n"});
}

Json truth_figures(const MotionScore& s) {
  const auto figures = [&](const Distances& d) {
    return Json{{"pairs", d.count},
                {"median", d.median},
                {"p90", d.p90},
                {"median_percent", 100 * d.median / s.edge},
                {"p90_percent", 100 * d.p90 / s.edge}};
  };
  return {{"box_edge", s.edge},
          {"voxel", s.voxel},
          {"correspondence", figures(s.canonical)},
          {"track", figures(s.tracked)},
          {"track_far", figures(s.tracked_far)},
          {"track_folded_share", s.folded},
          {"static_pairs", s.still_pairs},
          {"static_moved_share", s.still_moved},
          {"moving_pairs", s.moving_pairs},
          {"moving_missed_share", s.moving_missed}};
}

void print_truth(const MotionScore& s) {
  const auto line = [](const char* what, std::size_t pairs, const std::string& figures) {
    fmt::print("{:<28} {}\n", what, pairs > 0 ? figures : "no pairs");
  };
  const auto distances = [&](const char* what, const Distances& d) {
    line(what, d.count,
         fmt::format("median {:.4f} ({:.2f}% of the box), 90th percentile {:.4f} ({:.2f}%)   ({} pairs)",
                     d.median, 100 * d.median / s.edge, d.p90, 100 * d.p90 / s.edge, d.count));
  };
  const auto share = [&](const char* what, double of, std::size_t pairs, const std::string& more = "") {
    line(what, pairs, fmt::format("{:.2f}% of {} pairs{}", 100 * of, pairs, more));
  };
  distances("correspondence error", s.canonical);
  distances("track error", s.tracked);
  distances("over half of all time", s.tracked_far);
  share("tracks flagged as folded", s.folded, s.tracked.count);
  share("static surface moved", s.still_moved, s.still_pairs,
        fmt::format(" by more than half a voxel ({:.4f})", 0.5 * s.voxel));
  share("moving surface left still", s.moving_missed, s.moving_pairs);
}

int eval_run(const EvalOptions& o) {
  if (o.run.empty())
    fail({"eval", "there is no RUN to measure", "the folder of a run, or --pictures DIR with --data DATASET",
          "", ""});
  OuterMetrics metrics(o.metrics);
  const Device device = choose_device(o.device);
  const int across = across_of(o.antialias);
  const ModelFile read(o.run);
  Otherwise otherwise = o.otherwise;
  if (!o.masks.empty()) otherwise.masks = o.masks;
  const Run run = open_run(o.run, otherwise);
  const Dataset data = open_split(run, o.data, o.split, o.room);
  if (!o.images.empty()) claim_pictures(o.images, run, o.split);
  std::vector<SurfaceFrame>
      truth;  // read before the views are rendered: an absent file should be told at once
  if (o.truth) {
    truth = read_truth(data.path, *data.find(o.split), float(kSilhouette) * run.model.box.longest_edge());
  }
  std::optional<TruthVolumes> volumes;
  if (!o.truth_volume.empty())
    volumes = open_truth_volumes(o.truth_volume, run.model.time_map, !run.record.rules.between.empty());
  std::vector<std::string> notes = volumes ? volumes->notes : std::vector<std::string>();
  notes.insert(notes.end(), data.notes.begin(), data.notes.end());
  if (!o.json) print_scores_head(o.split, notes);
  Renderer renderer = make_renderer(run.model, device);
  const Scores scores = evaluate(
      run.model, renderer, *data.find(o.split),
      [&](const Frame& frame, const View& v) {
        frame.image.give_back();
        if (!o.json) print_view(frame, v);
        metrics.take(frame, v);
        if (!o.images.empty()) save_view(run.model, v, frame, o.images);
      },
      across);
  Json result = scores_json(scores);
  metrics.finish(result);
  const bool flat = run.record.parallax && *run.record.parallax < kLeastParallax;
  result["depth_determined"] = !flat;
  result["eval_seconds"] = scores.seconds;
  result["eval_device"] = describe(device);
  result["eval_data"] = whole_path(data.path).string();
  result["downscale"] = data.downscale;
  result["background"] = triple(run.background());
  result["masks"] = data.masks ? data.masks->use : "none";
  std::optional<HeldCamera> held;
  if (const std::optional<Dataset> film = open_film(run, o.data, o.room))
    held = held_camera_test(run.model, renderer, *film->find("train"), *data.find(o.split));
  if (held) result[kHeldCamera] = held_camera_json(*held);
  MotionScore motion;
  if (o.truth) {
    motion = score_motion(run.model, truth);
    result["truth"] = truth_figures(motion);
  }
  std::optional<VolumeScore> volume;
  if (volumes) {
    volume = score_volumes(run.model, *volumes);
    result["truth_volume"] = volume_json(*volume);
  }
  if (!o.json) print_means(scores, result);
  if (held && !o.json) fmt::print("{}\n", held_camera_line(*held));
  if (flat) {
    notes.push_back(fmt::format(
        "all training cameras see the scene from within {:.2g} degrees: its depth is not determined, and "
        "these figures say nothing of views from elsewhere",
        *run.record.parallax));
    if (!o.json) fmt::print("note: {}\n", notes.back());
  }
  if (o.truth && !o.json) print_truth(motion);
  if (volume && !o.json) print_volumes(*volume);
  const bool own = own_pictures(run, o.data);
  if (!own) {
    notes.push_back(
        "these are pictures of another data set: the run does not keep their figures; --out FILE does");
    if (!o.json) fmt::print("note: {}\n", notes.back());
  }
  run::flush_output();
  std::optional<Error> unsaved;  // figures are told all the same
  if (!o.out.empty()) try {
      write_file(o.out, {json_text(result, 2) + "\n"}, Named::by_user);
    } catch (const Error& error) {
      unsaved = error;
    }
  // The run keeps figures of its own pictures, shown as all are.
  if (own && !otherwise.any() && across == 0) try {
      save(run, read, result);
    } catch (const Error& error) {  // such as a run that may be read alone; --out has the figures
      if ((o.out.empty() || error.fault != Fault::output) && !unsaved) unsaved = error;
      notes.push_back(fmt::format("the run does not keep these figures: {}", error.what()));
      if (!unsaved && !o.json) Teller(choose_talk(false, false)).note(notes.back());
    }
  if (o.json) tell_scores(result, notes);
  run::flush_output();
  if (unsaved) throw Error(*unsaved);
  return 0;
}

int eval(const EvalOptions& o) {
  if (!o.out.empty() && of_run(fs::absolute(o.out)))
    fail({"--out", "a run keeps its own figures in this file", "another file", o.out,
          "none is needed: a run keeps the figures of its own pictures"});
  if (!o.out.empty()) probe_output_file(o.out, are_figures);
  return o.pictures.empty() ? eval_run(o) : eval_pictures(o);
}

}  // namespace

Action eval_command(CLI::App& verb) {
  auto o = std::make_shared<EvalOptions>();
  verb.add_option("RUN", o->run, "the run to measure, or to whose truth pictures are compared");
  heading(verb, kData);
  verb.add_option("--data", o->data, "the data set, if not the run's own or no longer where it was");
  verb.add_option("--split", o->split, "whose pictures to compare with")
      ->type_name("{test,val,train}")
      ->capture_default_str();
  heading(verb, "Measure");
  CLI::Option* images =
      verb.add_option("--images", o->images,
                      "folder for pictures: truth, render, error; depth, displacement, what moves (red)");
  CLI::Option* truth = verb.add_flag("--truth", o->truth,
                                     "compare the motion with the data set's truth/ (see docs/formats.md)");
  CLI::Option* volumes = verb.add_option(
      "--truth-volume", o->truth_volume,
      "folder with true densities over time to compare the model's with (see docs/formats.md)");
  CLI::Option* pictures =
      verb.add_option("--pictures", o->pictures,
                      "folder of another method's pictures, which are measured instead of the run's: on the "
                      "truth of RUN, or without one on that of --data")
          ->type_name("DIR");
  for (CLI::Option* of_model : {images, truth, volumes}) pictures->excludes(of_model);
  verb.add_option("--match", o->match,
                  "which of these is of which frame: by name (r_003.png is of r_003), or the first in order "
                  "of the first frame")
      ->type_name("{name,order}")
      ->check(CLI::IsMember({"name", "order"}))
      ->needs(pictures)
      ->capture_default_str();
  pictures->excludes(add_antialias(verb, o->antialias));
  verb.add_option("--metric", o->metrics,
                  "another figure, NAME=COMMAND: given a render and its truth, two PNG files, COMMAND prints "
                  "a number; with {list} in it, a file of such pairs, a number for each; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--out", o->out, "a file for the figures as JSON, beside what the run keeps")
      ->type_name("FILE");
  add_otherwise(verb, o->otherwise);
  add_masks(verb, o->masks);
  add_picture_room(verb, o->room.memory, o->room.cache);
  add_json(verb, o->json);
  add_threads(verb, o->threads);
  add_device(verb, o->device);
  return [o] { return with_threads(o->threads, [&] { return eval(*o); }); };
}

}  // namespace splinevox::cli
