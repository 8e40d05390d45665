// SPDX-License-Identifier: Apache-2.0
// Nerfies and HyperNeRF: a JSON file per camera with OpenCV axes, pictures in several sizes, a scene that is
// shifted and scaled.
#include <algorithm>
#include <cmath>

#include "data/json_file.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double number_in(const json& object, const char* field, const std::string& where,
                 std::optional<double> otherwise = {}) {
  const std::optional<double> value = number_field(object, field, where);
  if (!value && !otherwise)
    fail({where, std::string("'") + field + "' is missing", "a number", "no such field", ""});
  return value ? *value : *otherwise;
}

/// A list of `count` numbers; zeros where it is absent and need not be there.
std::vector<double> numbers_in(const json& object, const char* field, std::size_t count, bool needed,
                               const std::string& where) {
  const auto found = object.find(field);
  if (found == object.end() && !needed) return std::vector<double>(count, 0.0);
  const bool good = found != object.end() && found->is_array() && found->size() == count &&
                    std::all_of(found->begin(), found->end(), [](const json& v) { return v.is_number(); });
  if (!good)
    fail({where, std::string("'") + field + "' is not " + std::to_string(count) + " numbers",
          "an array of " + std::to_string(count), found == object.end() ? "no such field" : shown(*found),
          ""});
  return found->get<std::vector<double>>();
}

std::vector<std::string> ids_in(const json& file, const char* field, const std::string& where) {
  const auto found = file.find(field);
  std::vector<std::string> ids;
  if (found == file.end()) return ids;
  if (!found->is_array())
    fail({where, std::string("'") + field + "' is not a list", "an array of names", shown(*found), ""});
  for (const json& id : *found) {
    if (!id.is_string() || id.get_ref<const std::string&>().empty() ||
        id.get_ref<const std::string&>().find_first_of(std::string("/\0", 2)) != std::string::npos)
      fail({where, std::string("'") + field + "' holds something that is no name of a frame",
            "text without /", shown(id), ""});
    ids.push_back(id.get<std::string>());
  }
  return ids;
}

/// Where the scene lies: world to scene units is (p - center) * scale.
struct Frame {
  Vec3d center{};
  double scale = 1;
  std::optional<std::array<double, 2>> near_far;
};

Frame read_scene_frame(const fs::path& folder, std::vector<std::string>& notes) {
  const fs::path path = folder / "scene.json";
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    notes.push_back("there is no scene.json: positions are taken as they are");
    return {};
  }
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  if (!file.is_object())
    fail({where, "this is not a scene", "an object with 'center' and 'scale'", shown(file), ""});
  const std::vector<double> c = numbers_in(file, "center", 3, true, where);
  Frame frame{{c[0], c[1], c[2]}, number_in(file, "scale", where), {}};
  if (!(frame.scale > 0 && frame.scale < 1e12))
    fail({where, "'scale' is out of range", "above 0", number(frame.scale), ""});
  const double near = number_in(file, "near", where, 0), far = number_in(file, "far", where, 0);
  if (far > near && near >= 0) frame.near_far = {{near, far}};
  return frame;
}

RawFrame read_camera(const fs::path& folder, const std::string& id, const Frame& scene) {
  const fs::path path = folder / "camera" / (id + ".json");
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  if (!file.is_object())
    fail({where, "this is not a camera", "an object with 'orientation'", shown(file), ""});
  const auto rows = file.find("orientation");
  if (rows == file.end() || !rows->is_array() || rows->size() != 3)
    fail({where, "'orientation' is not a rotation", "3 rows of 3 numbers, world to camera",
          rows == file.end() ? "no such field" : shown(*rows), ""});
  std::array<Vec3d, 3>
      axes;  // rows of world to camera are the camera's axes in the world: right, down, forwards
  for (std::size_t r = 0; r < 3; ++r) {
    const std::vector<double> v =
        numbers_in(json{{"orientation", (*rows)[r]}}, "orientation", 3, true, where);
    axes[r] = {v[0], v[1], v[2]};
  }
  axes[1] = -axes[1];
  axes[2] = -axes[2];
  const std::vector<double> p = numbers_in(file, "position", 3, true, where),
                            c = numbers_in(file, "principal_point", 2, true, where);
  const std::vector<double> k = numbers_in(file, "radial_distortion", 3, false, where),
                            t = numbers_in(file,
                                           file.contains("tangential_distortion") ? "tangential_distortion"
                                                                                  : "tangential",
                                           2, false, where);
  const std::vector<double> size = numbers_in(file, "image_size", 2, true, where);
  if (const double skew = number_in(file, "skew", where, 0); skew != 0)
    fail({where, "a lens with skew is not supported", "'skew' 0 or absent", number(skew), ""});
  RawFrame frame;
  set_pose(frame, matrix_of(axes, scene.scale * (Vec3d{p[0], p[1], p[2]} - scene.center)), where);
  const double f = number_in(file, "focal_length", where);
  frame.lens = {{},   {},   f,       f * number_in(file, "pixel_aspect_ratio", where, 1),
                c[0], c[1], size[0], size[1],
                k[0], k[1], k[2],    {},
                t[0], t[1], {},      true};
  frame.name = id;
  frame.label = "frame " + id;
  return frame;
}

/// The folder of the largest pictures: rgb/1x, rgb/2x, ...
std::string picture_folder(const fs::path& folder, std::vector<std::string>& notes) {
  for (const int shrink : {1, 2, 4, 8, 16}) {
    const std::string name = "rgb/" + std::to_string(shrink) + "x";
    std::error_code ignored;
    if (!fs::is_directory(folder / name, ignored)) continue;
    notes.push_back("pictures are those of " + name);
    return name;
  }
  fail({printable((folder / "rgb").string()), "there are no pictures", "a folder 1x, 2x, 4x, 8x or 16x",
        "none of them", ""});
}

double time_of(const json& metadata, const std::string& id, const std::string& where) {
  const auto found = metadata.find(id);
  if (found == metadata.end() || !found->is_object())
    fail({where, "there is nothing about frame " + in_quotes(id), "an object with 'time_id' or 'warp_id'",
          "no such field", ""});
  const std::string at = where + ", frame " + printable(id);
  return number_in(*found, found->contains("time_id") ? "time_id" : "warp_id", at);
}

}  // namespace

bool is_nerfies(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "dataset.json", ignored) && fs::is_directory(folder / "camera", ignored);
}

RawScene read_nerfies(const fs::path& folder) {
  const std::string where = printable((folder / "dataset.json").string()),
                    meta_where = printable((folder / "metadata.json").string());
  const json file = read_json(folder / "dataset.json", where),
             metadata = read_json(folder / "metadata.json", meta_where);
  if (!file.is_object() || !metadata.is_object())
    fail({where, "this and metadata.json are not a data set", "an object each", shown(file), ""});
  RawScene scene;
  // DyCheck alone writes it. Its alpha says where depth was measured; its own training weighs errors by that.
  std::error_code unread;
  scene.alpha_ignores = fs::exists(folder / "extra.json", unread);
  const Frame frame_of_scene = read_scene_frame(folder, scene.notes);
  const std::string pictures = picture_folder(folder, scene.notes);
  for (const auto& [field, name] : {std::pair{"train_ids", "train"}, {"val_ids", "test"}}) {
    RawSplit split{name, where, true, {}};
    for (const std::string& id : ids_in(file, field, where)) {
      split.frames.push_back(read_camera(folder, id, frame_of_scene));
      split.frames.back().file_path = pictures + "/" + id;
      split.frames.back().time = time_of(metadata, id, meta_where);
    }
    if (!split.frames.empty()) scene.splits.push_back(std::move(split));
  }
  if (scene.splits.empty() || scene.splits[0].name != "train")
    fail({where, "there are no training frames", "names in 'train_ids'", "none", ""});
  if (scene.splits.size() == 1) {
    scene.one_list = true;
  } else {
    scene.notes.push_back("the frames of val_ids are the test split");
  }
  std::error_code ignored;
  if (fs::exists(folder / "points.npy", ignored)) {
    const std::string points_where = printable((folder / "points.npy").string());
    const NpyTable table = read_npy(folder / "points.npy", points_where);
    if (table.columns != 3)
      fail({points_where, "these are no points", "3 columns", std::to_string(table.columns), ""});
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < table.rows; ++i)
      points.push_back(frame_of_scene.scale *
                       (Vec3d{table.at(i, 0), table.at(i, 1), table.at(i, 2)} - frame_of_scene.center));
    scene.box = points_box(std::move(points));
  }
  const RawSplit& train = scene.splits[0];
  if (!scene.box && frame_of_scene.near_far)
    scene.box = frusta_box(train, std::vector(train.frames.size(), *frame_of_scene.near_far));
  return scene;
}

}  // namespace splinevox::data
