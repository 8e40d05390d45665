// SPDX-License-Identifier: Apache-2.0
// COLMAP models beside their pictures. Times are not theirs: times.txt or the pictures' names give them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "data/layouts/colmap_model.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/still_model.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool has_model(const fs::path& folder, const char* ending) {
  return is_there(folder / (std::string("cameras") + ending)) &&
         is_there(folder / (std::string("images") + ending));
}

/// Where programs put a model, in the order in which a folder is tried: 3DGS, COLMAP, nerfstudio,
/// instant-ngp.
constexpr const char* kPlaces[] = {"sparse/0",           "sparse",
                                   "colmap/sparse/0",    "colmap/sparse",
                                   "colmap_sparse/0",    "colmap_sparse",
                                   "undistorted/sparse", "undistorted/sparse/0",
                                   "dense/sparse",       "dense/0/sparse",
                                   "distorted/sparse/0", "distorted/sparse",
                                   "colmap_text",        "."};

/// Where the model lies within the folder, relative to it; empty if nowhere.
fs::path model_folder(const fs::path& folder) {
  for (const char* inside : kPlaces)
    if (has_model(folder / inside, ".bin") || has_model(folder / inside, ".txt")) return inside;
  return {};
}

/// The rows of the rotation are the camera's axes in the world: right, down, forwards.
std::array<Vec3d, 3> rows_of(const std::array<double, 4>& quaternion, const std::string& where) {
  double norm = 0;
  for (const double q : quaternion) norm += q * q;
  norm = std::sqrt(norm);
  if (!(norm > 1e-6 && norm < 1e6))
    fail({where, "the rotation is no quaternion", "four numbers of length 1", "length " + number(norm), ""});
  const double w = quaternion[0] / norm, x = quaternion[1] / norm, y = quaternion[2] / norm,
               z = quaternion[3] / norm;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

}  // namespace

RawFrame frame_of(const ColmapModel& model, const ColmapImage& image) {
  const std::string where = model.where + ", image " + printable(image.name);
  const auto camera = model.cameras.find(image.camera);
  if (camera == model.cameras.end())
    fail({where, "there is no such camera", "the number of a camera in the cameras file",
          std::to_string(image.camera), ""});
  RawFrame frame;
  set_pose(frame, matrix_of_opencv(rows_of(image.rotation, where), image.translation), where);
  frame.lens = lens_of(camera->second, where);
  frame.file_path = image.name;
  frame.label = "image " + printable(image.name);
  return frame;
}

namespace {

/// What stands before an image's name to give its path in the folder: where the first one that exists lies.
/// Pictures beside the model are its own before any other; of a distorted model they are in input, while
/// images has them undistorted.
std::string picture_prefix(const fs::path& folder, const fs::path& inside,
                           const std::vector<ColmapImage>& images, const std::string& where) {
  const std::string place = inside.generic_string();
  const std::string base = place.substr(0, std::min(place.find("sparse"), place.size()));
  std::vector<std::string> prefixes;
  if (base.ends_with('/')) prefixes = {base + "images/", base + "input/"};
  if (base == "distorted/") prefixes.emplace_back("input/");
  for (const char* usual : {"images/", "input/", "rgb/", "", "images_2/", "images_4/", "images_8/"})
    prefixes.emplace_back(usual);
  for (const ColmapImage& image : images)
    for (const std::string& prefix : prefixes)
      if (is_there(folder / (prefix + image.name))) return prefix;
  fail({where, "the pictures are not there", in_quotes("images/" + images[0].name),
        "no such file, nor in input, rgb, the folder itself or images_2, _4, _8; in the folder: " +
            list_of(folders_in(folder)),
        "copy the pictures beside the model"});
}

/// COLMAP writes a model for every part of the pictures that it could not join to the others.
void note_other_models(const fs::path& folder, const fs::path& place, std::vector<std::string>& notes) {
  if (place.filename() != "0") return;
  std::vector<std::string> others;
  for (const std::string& name : folders_in(folder / place.parent_path()))
    if (const fs::path other = folder / place.parent_path() / name;
        name != "0" && (has_model(other, ".bin") || has_model(other, ".txt")))
      others.push_back((place.parent_path() / name).generic_string());
  if (!others.empty())
    notes.push_back(fmt::format(
        "there are other models, of pictures that could not be joined to these: {}; {} is read alone",
        list_of(others), place.generic_string()));
}

/// The folders that hold the model's pictures, and all folders in `top`, but for those of masks.
std::set<std::string> picture_folders(const fs::path& folder, const std::string& top, const RawSplit& all) {
  std::set<std::string> folders;
  for (const RawFrame& frame : all.frames)
    folders.insert(fs::path(frame.file_path).lexically_normal().parent_path().generic_string());
  if (top.empty()) return folders;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder / top, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code ignored;
    if (!it->is_directory(ignored)) continue;
    if (is_mask_folder(it->path().filename().string()))
      it.disable_recursion_pending();
    else
      folders.insert(it->path().lexically_relative(folder).generic_string());
  }
  return folders;
}

/// Pictures that lie among those of the model and that it has no camera for.
void note_pictures_without(const fs::path& folder, const std::string& top, const RawSplit& all,
                           std::vector<std::string>& notes) {
  std::set<std::string> placed;
  for (const RawFrame& frame : all.frames)
    placed.insert(fs::path(frame.file_path).lexically_normal().generic_string());
  std::size_t count = 0, without = 0;
  std::string first;
  for (const std::string& inside : picture_folders(folder, top, all))
    for (const std::string& name : without_masks(files_in(folder / inside, FileKind::picture))) {
      const std::string path = (fs::path(inside) / name).generic_string();
      ++count;
      if (placed.count(path)) continue;
      if (++without == 1) first = path;
    }
  if (without > 0)
    notes.push_back(fmt::format("{} of {} pictures have no camera in the model, such as {}", without, count,
                                in_quotes(first)));
}

}  // namespace

bool is_colmap(const fs::path& folder) { return !model_folder(folder).empty(); }

RawScene read_colmap(const fs::path& folder) {
  const fs::path place = model_folder(folder), inside = folder / place;
  ColmapModel model = has_model(inside, ".bin") ? read_colmap_binary(inside) : read_colmap_text(inside);
  std::size_t backslashes = 0;
  for (const ColmapImage& image : model.images) backslashes += image.name.find('\\') != std::string::npos;
  if (backslashes > 0 &&
      !std::any_of(model.images.begin(), model.images.end(), [&](const ColmapImage& image) {
        return is_there(folder / "images" / image.name) || is_there(folder / image.name);
      }))
    for (ColmapImage& image : model.images) std::replace(image.name.begin(), image.name.end(), '\\', '/');
  else
    backslashes = 0;
  if (model.images.empty()) fail({model.where, "the model has no images", "at least one", "none", ""});
  std::sort(model.images.begin(), model.images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  RawScene scene;
  scene.splits.push_back({"train", model.where, false, {}});
  scene.one_list = true;
  if (backslashes > 0)
    scene.notes.push_back(
        fmt::format("{} pictures have paths of Windows, which were taken with /", backslashes));
  RawSplit& all = scene.splits[0];
  for (const ColmapImage& image : model.images) all.frames.push_back(frame_of(model, image));
  scene.box = points_box(std::move(model.points));
  note_other_models(folder, place, scene.notes);
  if (take_still_model(folder, scene)) return scene;
  const std::string prefix = picture_prefix(folder, place, model.images, model.where);
  for (RawFrame& frame : all.frames) frame.file_path = prefix + frame.file_path;
  if (prefix.rfind("images_", 0) == 0)
    scene.notes.push_back("pictures are those of " + prefix.substr(0, prefix.size() - 1));
  note_pictures_without(folder, prefix, all, scene.notes);
  return scene;
}

}  // namespace splinevox::data
