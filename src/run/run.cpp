// SPDX-License-Identifier: Apache-2.0
#include "splinevox/run/run.hpp"

#include <filesystem>

#include "core/own_folder.hpp"
#include "run/held_camera.hpp"
#include "run/memory_needs.hpp"
#include "run/run_folder.hpp"
#include "run/train_options.hpp"
#include "run/training_pictures.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {

void check_run(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    fail({path, "there is no such run", "the folder that `splinevox train --out` made", "", ""});
  if (fs::is_regular_file(path, ignored))
    fail({path, "this is a file, not a run", "the folder that `splinevox train --out` made", "",
          fs::path(path).filename() == "model.vdb" ? fs::path(path).parent_path().string() : ""});
  check_own_folder(path, Depth::all);
  if (!fs::is_regular_file(path + "/model.vdb", ignored))
    fail({path, "this is not a run: there is no model.vdb in it",
          "the folder that `splinevox train --out` made", "",
          fs::exists(path + "/" + kCheckpoint, ignored)
              ? "splinevox train DATASET --out " + path + " --resume"
              : ""});
}

Run open_run(const std::string& path) {
  check_run(path);
  Run run;
  run.path = path;
  while (run.path.size() > 1 && run.path.back() == '/') run.path.pop_back();
  read_run_config(run.path, run.config, run.record);
  run.model = load_model(run.path + "/model.vdb", &run.notes);
  return run;
}

Run open_run(const std::string& path, const Otherwise& otherwise) {
  Run run = open_run(path);
  if (otherwise.downscale) run.config.run.downscale = *otherwise.downscale;
  if (otherwise.masks) run.record.rules.masks = *otherwise.masks;
  if (!otherwise.background) return run;
  const std::vector<float> c = parse_background(*otherwise.background);
  run.model.background = {.color = {c[0], c[1], c[2]}};
  return run;
}

namespace {

LoadOptions options_of(const Run& run, const PictureRoom& room) {
  LoadOptions load;
  load.downscale = run.config.run.downscale;
  load.time_map = run.record.time_map;
  load.rules = run.record.rules;
  load.inside = true;
  load.cache = room.cache;
  load.room = [bound = memory_bound(room.memory)](const Dataset&) { return bound; };
  return load;
}

const std::string& folder_of(const Run& run, const std::string& dataset) {
  return dataset.empty() ? run.record.dataset : dataset;
}

}  // namespace

Dataset open_split(const Run& run, const std::string& dataset, const std::string& split,
                   const PictureRoom& room, Pixels pixels) {
  LoadOptions load = options_of(run, room);
  load.splits = {split};
  load.pixels = pixels == Pixels::read;
  Dataset data = load_dataset(folder_of(run, dataset), load);
  if (split != "train") check_held_out(run.path, load, data);
  return data;
}

std::optional<Dataset> open_film(const Run& run, const std::string& dataset, const PictureRoom& room) {
  LoadOptions load = options_of(run, room);
  load.pixels = false;
  const Dataset poses = load_dataset(folder_of(run, dataset), load);
  const Split* train = poses.find("train");
  if (!train || !is_film(*train, run.model.box)) return {};
  return open_split(run, dataset, "train", room);
}

}  // namespace splinevox::run
