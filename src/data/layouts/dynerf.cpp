// SPDX-License-Identifier: Apache-2.0
// Cameras that stand still, a row of poses_bounds.npy each: a film per camera (DyNeRF), or a folder per
// camera with the film's frames as pictures.
#include <fmt/format.h>

#include <algorithm>

#include "data/layouts/folder_list.hpp"
#include "data/layouts/pose_rows.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/rig_footage.hpp"
#include "data/message_text.hpp"
#include "data/times/names.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

bool named_cam(const std::string& name) { return lower_case(name).starts_with("cam"); }

/// What may be a rig's cameras: names in the folder, in the order in which people count.
struct RigParts {
  std::vector<std::string> films, folders;
};

RigParts rig_parts(const fs::path& folder) {
  RigParts parts{files_in(folder, FileKind::film), {}};
  for (const std::string& name : folders_in(folder))
    if (!is_no_camera(name) && !pictures_of_camera(folder, name).empty()) parts.folders.push_back(name);
  return parts;
}

/// Those that are as many as there are rows: all that are named cam, else all. None if neither fits.
std::vector<std::string> as_many(const std::vector<std::string>& names, std::size_t rows) {
  std::vector<std::string> cams;
  std::copy_if(names.begin(), names.end(), std::back_inserter(cams), named_cam);
  return cams.size() == rows ? cams : names.size() == rows ? names : std::vector<std::string>();
}

[[noreturn]] void fail_count(const RigParts& parts, std::size_t rows, const std::string& where) {
  const std::string expected = std::to_string(rows) + ", one per row";
  const std::string folders = "folders of pictures: " + list_of(parts.folders);
  if (parts.films.empty())
    fail({where, "there are not as many folders of pictures as cameras", expected,
          fmt::format("{}: {}", parts.folders.size(), list_of(parts.folders)),
          "one folder per camera, such as cam00/images/0000.png, and nothing beside them"});
  fail({where, "there are not as many films as cameras", expected,
        fmt::format("{}: {}{}", parts.films.size(), list_of(parts.films),
                    parts.folders.empty() ? "" : "; " + folders),
        "remove what does not belong, or make the poses again"});
}

/// A rig being read: every row's camera is in one split, the first in the test split.
struct Rig {
  RawSplit train, test, cameras;
  std::vector<std::array<double, 2>> depths;

  Rig(const std::string& where, bool timed)
      : train{"train", where, timed, {}},
        test{"test", where, timed, {}},
        cameras{"train", where, timed, {}} {}

  RawSplit& split_of(std::size_t camera) { return camera == 0 && cameras.frames.size() > 1 ? test : train; }
};

/// A frame's time is its time stamp, in frames of the first film.
std::vector<std::string> add_films(Rig& rig, const fs::path& folder, const std::vector<std::string>& names) {
  int fewest = 1 << 30, most = 0;
  double rate = 0;
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < names.size(); ++i) {
    RawFrame& camera = rig.cameras.frames[i];
    camera.camera = fs::path(names[i]).stem().string();
    const int frames = add_film(folder, camera, names[i], rate, rig.split_of(i).frames, notes);
    fewest = std::min(fewest, frames);
    most = std::max(most, frames);
  }
  if (const std::string note = note_on_lengths(fewest, most); !note.empty()) notes.push_back(note);
  return notes;
}

/// Times are those of the pictures' names: settle_times gives them.
std::vector<std::string> add_folders(Rig& rig, const fs::path& folder,
                                     const std::vector<std::string>& names) {
  std::size_t fewest = SIZE_MAX, most = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::vector<std::string> paths = pictures_of_camera(folder, names[i]);
    fewest = std::min(fewest, paths.size());
    most = std::max(most, paths.size());
    rig.cameras.frames[i].camera = names[i];
    add_pictures(rig.cameras.frames[i], paths, rig.split_of(i).frames);
  }
  std::vector<std::string> notes{
      fmt::format("every folder of pictures is a camera that stands still: {}", list_of(names))};
  if (fewest < most)
    notes.push_back(fmt::format("cameras have from {} to {} pictures; equal numbers in names are one moment",
                                fewest, most));
  return notes;
}

}  // namespace

bool is_dynerf(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / "poses_bounds.npy", ignored)) return false;
  const RigParts parts = rig_parts(folder);
  if (std::any_of(parts.films.begin(), parts.films.end(), named_cam)) return true;
  bool llff = false;
  for (const char* inside : {"images", "images_2", "images_4", "images_8"})
    llff |= !files_in(folder / inside, FileKind::picture).empty();
  if (!llff) return !parts.films.empty() || !parts.folders.empty();
  try {  // one picture of each camera is there too, for COLMAP
    std::string where;
    const std::vector<std::string> rig = as_many(parts.folders, read_poses_bounds(folder, where).size());
    return !rig.empty() && std::all_of(rig.begin(), rig.end(), named_cam);
  } catch (const Error&) {
    return false;  // LLFF's reader says what is wrong with the table
  }
}

/// Every film or folder is a camera that stands still, the first of them the test view.
RawScene read_dynerf(const fs::path& folder) {
  std::string where;
  const std::vector<PoseRow> rows = read_poses_bounds(folder, where);
  const RigParts parts = rig_parts(folder);
  std::vector<std::string> names = as_many(parts.films, rows.size());
  const bool films = !names.empty();
  if (!films) names = as_many(parts.folders, rows.size());
  if (names.empty()) fail_count(parts, rows.size(), where);
  Rig rig(where, films);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rig.cameras.frames.push_back(frame_of_row(rows[i], true, where + ", row " + std::to_string(i)));
    rig.depths.push_back(rows[i].near_far);
  }
  RawScene scene;
  scene.notes = films ? add_films(rig, folder, names) : add_folders(rig, folder, names);
  const bool usual = std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return name.starts_with("cam") && fs::path(name).extension() == ".mp4";
  });
  if (films && !usual) scene.notes.push_back("every film is a camera: " + list_of(names));
  if (!std::is_sorted(names.begin(), names.end()))
    scene.notes.push_back("rows of poses_bounds.npy are taken for the cameras as people count: " +
                          list_of(names));
  scene.box = frusta_box(rig.cameras, rig.depths);
  scene.splits.push_back(std::move(rig.train));
  if (!rig.test.frames.empty()) {
    scene.notes.push_back(printable(names[0]) + " is the test split");
    scene.splits.push_back(std::move(rig.test));
  }
  return scene;
}

}  // namespace splinevox::data
