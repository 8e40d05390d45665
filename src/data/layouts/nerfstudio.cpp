// SPDX-License-Identifier: Apache-2.0
// transforms.json of nerfstudio and instant-ngp: one file for all frames, lenses for all or per frame,
// distortion.
#include <algorithm>
#include <map>
#include <utility>

#include "data/json_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/still_model.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// "./images/a.png" and "images/a.png" are one file.
std::string as_listed(const std::string& path) { return fs::path(path).lexically_normal().generic_string(); }

/// {train,val,test}_filenames, where the file has them: which split a picture belongs to.
std::map<std::string, std::string> read_split_lists(const json& file, const std::string& where,
                                                    std::vector<std::string>& notes) {
  std::map<std::string, std::string> split_of;
  std::size_t trained = 0;
  for (const char* split : {"train", "test", "val"}) {  // where val and test are the same: test
    const std::string field = std::string(split) + "_filenames";
    const auto found = file.find(field);
    if (found == file.end()) continue;
    if (!found->is_array())
      fail({where, "'" + field + "' is not a list", "an array of file paths", shown(*found), ""});
    for (const json& name : *found) {
      if (!name.is_string())
        fail({where, "'" + field + "' holds something else than paths", "file paths as in 'frames'",
              shown(name), ""});
      const auto [found_split, fresh] = split_of.emplace(as_listed(name.get<std::string>()), split);
      trained += !fresh && found_split->second == "train" && split != found_split->second ? 1 : 0;
    }
  }
  if (trained > 0)
    notes.push_back(
        std::to_string(trained) +
        " names in the lists of val and test are in several lists: they train, and are not held out");
  return split_of;
}

/// nerfstudio's own programs write val and test lists that are the same: then there is a test split alone.
RawScene by_lists(RawSplit all, const std::map<std::string, std::string>& split_of) {
  RawScene scene;
  std::size_t nowhere = 0;
  for (const char* name : {"train", "val", "test"}) {
    RawSplit split{name, all.file, all.timed, {}, {}, all.tracks};
    for (const RawFrame& frame : all.frames)
      if (const auto found = split_of.find(as_listed(frame.file_path));
          found != split_of.end() && found->second == name)
        split.frames.push_back(frame);
    if (!split.frames.empty()) scene.splits.push_back(std::move(split));
  }
  for (const RawFrame& frame : all.frames) nowhere += split_of.count(as_listed(frame.file_path)) == 0;
  if (nowhere > 0)
    scene.notes.push_back(std::to_string(nowhere) + " of " + std::to_string(all.frames.size()) +
                          " frames are in none of the lists of file names and are left out");
  if (scene.splits.empty() || scene.splits[0].name != "train")
    fail({all.file, "no frame is in 'train_filenames'", "file paths as in 'frames'", "none that match",
          "remove the lists of file names: every eighth frame is then held out"});
  return scene;
}

}  // namespace

bool is_nerfstudio(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "transforms.json", ignored);
}

/// applied_transform and applied_scale say what was done to the poses before they were written: they are in
/// the world of the frames already and must not be applied again. aabb_scale, scale and offset are of
/// instant-ngp's own cube.
RawScene read_nerfstudio(const fs::path& folder) {
  const fs::path path = folder / "transforms.json";
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  RawSplit all = read_frames(file, where);
  const json& frames = frames_of(file, where);
  for (std::size_t i = 0; i < frames.size(); ++i) all.frames[i].label = "frame " + std::to_string(i);
  read_times(frames, "time", all);
  std::vector<std::string> notes = std::exchange(all.notes, {});
  const std::map<std::string, std::string> split_of = read_split_lists(file, where, notes);
  RawScene scene;
  if (split_of.empty()) {
    scene.splits.push_back(std::move(all));
    scene.one_list = true;
  } else {
    scene = by_lists(std::move(all), split_of);
  }
  scene.notes.insert(scene.notes.begin(), notes.begin(), notes.end());
  scene.box = read_scene_box(file, where);
  take_still_model(folder, scene);
  return scene;
}

}  // namespace splinevox::data
