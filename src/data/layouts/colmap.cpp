// SPDX-License-Identifier: Apache-2.0
// COLMAP models beside their pictures. Times are not theirs: times.txt or the pictures' names give them.
#include <algorithm>
#include <cmath>

#include "data/layouts/colmap_model.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr ColmapKind kKinds[] = {{"SIMPLE_PINHOLE", 0, 3, true},
                                 {"PINHOLE", 1, 4, true},
                                 {"SIMPLE_RADIAL", 2, 4, true},
                                 {"RADIAL", 3, 5, true},
                                 {"OPENCV", 4, 8, true},
                                 {"OPENCV_FISHEYE", 5, 8, true},
                                 {"FULL_OPENCV", 6, 12, false},
                                 {"FOV", 7, 5, false},
                                 {"SIMPLE_RADIAL_FISHEYE", 8, 4, true},
                                 {"RADIAL_FISHEYE", 9, 5, true},
                                 {"THIN_PRISM_FISHEYE", 10, 12, false}};

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool has_model(const fs::path& folder, const char* ending) {
  return is_there(folder / (std::string("cameras") + ending)) &&
         is_there(folder / (std::string("images") + ending));
}

/// Where the model lies within the folder; empty if nowhere.
fs::path model_folder(const fs::path& folder) {
  for (const char* inside : {"sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse", "."})
    if (has_model(folder / inside, ".bin") || has_model(folder / inside, ".txt")) return folder / inside;
  return {};
}

Lens lens_of(const ColmapCamera& camera, const std::string& where) {
  const ColmapKind& kind = *camera.kind;
  if (!kind.supported)
    fail({where, std::string("the camera model ") + kind.name + " is not supported",
          "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV or a fisheye of theirs", kind.name,
          "colmap image_undistorter makes PINHOLE pictures"});
  for (const double v : camera.params)
    if (!std::isfinite(v))
      fail({where, "a parameter of the camera is not finite", "finite numbers", number(v), ""});
  const std::string name = kind.name;
  const std::vector<double>& p = camera.params;
  const bool one_focal = name.rfind("SIMPLE_", 0) == 0 || name.rfind("RADIAL", 0) == 0;
  const std::size_t centre = one_focal ? 1 : 2, rest = centre + 2;
  Lens lens;
  lens.fl_x = p[0];
  lens.fl_y = p[one_focal ? 0 : 1];
  lens.cx = p[centre];
  lens.cy = p[centre + 1];
  lens.w = camera.width;
  lens.h = camera.height;
  lens.scaled = true;
  if (p.size() > rest) lens.k1 = p[rest];
  if (p.size() > rest + 1) lens.k2 = p[rest + 1];
  if (name == "OPENCV") {
    lens.p1 = p[6];
    lens.p2 = p[7];
  }
  if (name == "OPENCV_FISHEYE") {
    lens.k3 = p[6];
    lens.k4 = p[7];
  }
  if (name.ends_with("FISHEYE")) lens.fisheye = true;
  return lens;
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

RawFrame frame_of(const ColmapModel& model, const ColmapImage& image, const std::string& pictures) {
  const std::string where = model.where + ", image " + printable(image.name);
  const auto camera = model.cameras.find(image.camera);
  if (camera == model.cameras.end())
    fail({where, "there is no such camera", "the number of a camera in the cameras file",
          std::to_string(image.camera), ""});
  const std::array<Vec3d, 3> rows = rows_of(image.rotation, where);
  const Vec3d& t = image.translation;
  RawFrame frame;
  set_pose(frame, matrix_of({rows[0], -rows[1], -rows[2]}, -(t.x * rows[0] + t.y * rows[1] + t.z * rows[2])),
           where);
  frame.lens = lens_of(camera->second, where);
  frame.file_path = pictures + image.name;
  frame.label = "image " + printable(image.name);
  return frame;
}

/// What stands before an image's name to give its path in the folder: where the first one that exists lies.
std::string picture_prefix(const fs::path& folder, const std::vector<ColmapImage>& images,
                           const std::string& where) {
  for (const ColmapImage& image : images)
    for (const char* prefix : {"images/", "input/", "rgb/", "", "images_2/", "images_4/", "images_8/"})
      if (is_there(folder / (prefix + image.name))) return prefix;
  fail({where, "the pictures are not there", in_quotes("images/" + images[0].name),
        "no such file, nor in input, rgb, the folder itself or images_2, _4, _8",
        "copy the pictures beside the model"});
}

}  // namespace

const ColmapKind* find_kind(std::int64_t id) {
  for (const ColmapKind& kind : kKinds)
    if (kind.id == id) return &kind;
  return nullptr;
}

const ColmapKind* find_kind(const std::string& name) {
  for (const ColmapKind& kind : kKinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

bool is_colmap(const fs::path& folder) { return !model_folder(folder).empty(); }

RawScene read_colmap(const fs::path& folder) {
  const fs::path inside = model_folder(folder);
  ColmapModel model = has_model(inside, ".bin") ? read_colmap_binary(inside) : read_colmap_text(inside);
  if (model.images.empty()) fail({model.where, "the model has no images", "at least one", "none", ""});
  std::sort(model.images.begin(), model.images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  const std::string prefix = picture_prefix(folder, model.images, model.where);
  RawSplit all{"train", model.where, false, {}};
  for (const ColmapImage& image : model.images) all.frames.push_back(frame_of(model, image, prefix));
  std::vector<std::string> notes;
  if (prefix.rfind("images_", 0) == 0)
    notes.push_back("pictures are those of " + prefix.substr(0, prefix.size() - 1));
  RawScene scene;
  scene.splits.push_back(std::move(all));
  scene.one_list = true;
  scene.upright = false;  // COLMAP takes pictures as they are stored
  scene.box = points_box(std::move(model.points));
  scene.notes = std::move(notes);
  return scene;
}

}  // namespace splinevox::data
