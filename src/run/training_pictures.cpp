// SPDX-License-Identifier: Apache-2.0
#include "run/training_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <unordered_set>
#include <utility>
#include <vector>

#include "run/run_folder.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

using Sources = std::unordered_set<std::string>;

/// The pictures that the data set has for training as it is now.
Sources now_for_training(const std::string& dataset, LoadOptions load) {
  load.if_there = {"train"};
  load.pixels = false;
  const Dataset data = load_dataset(dataset, load);
  Sources sources;
  if (const Split* train = data.find("train"))
    for (const Frame& frame : train->frames) sources.insert(frame.source);
  return sources;
}

}  // namespace

std::string training_pictures_text(const Split& train) {
  std::string text;
  for (const Frame& frame : train.frames) text += frame.source + "\n";
  return text;
}

void check_held_out(const std::string& run, const LoadOptions& load, Dataset& data) {
  const std::string list = run + "/" + kTrainingPictures;
  if (!fs::exists(list)) {
    data.notes.push_back(
        "the run is of an older version and does not list its training pictures: whether the " +
        data.splits.front().name + " split has some of them is not known");
    return;
  }
  Sources trained;
  for (std::string& line : split_list(read_text_if_there(list), '\n')) trained.insert(std::move(line));
  const Split& split = data.splits.front();
  std::vector<std::string> both;
  for (const Frame& frame : split.frames)
    if (trained.contains(frame.source)) both.push_back(frame.source);
  if (both.empty()) return;
  const std::string count = fmt::format("{} of {} pictures of the {} split were trained on", both.size(),
                                        split.frames.size(), split.name);
  const Sources now = now_for_training(data.path, load);
  const auto listed_twice = [&](const std::string& source) { return now.contains(source); };
  if (std::all_of(both.begin(), both.end(), listed_twice)) {
    data.notes.push_back(
        fmt::format("{}, first {}: the data set itself has them for both, so figures of them are not of "
                    "held-out pictures",
                    count, both.front()));
    return;
  }
  fail({data.path,
        count +
            ": the data set is divided otherwise than it was for training, because pictures are missing or "
            "new, its lists or the use of masks are others, or the program is",
        "pictures that are not in " + list, "first " + both.front(),
        "give missing pictures back, leave --masks as the run has it, or train again; --split train "
        "(--camera dataset:train) has pictures that were trained on"});
}

}  // namespace splinevox::run
