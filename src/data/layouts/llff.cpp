// SPDX-License-Identifier: Apache-2.0
// Cameras as rows of numbers: LLFF's poses_bounds.npy and NR-NeRF's precomputed.json.
#include <algorithm>

#include "data/json_file.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/layouts/pose_rows.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "data/times/names.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Nested arrays of numbers, flat; the shape must be `shape`.
void flatten(const json& value, std::initializer_list<std::size_t> shape, std::vector<double>& out,
             const std::string& where) {
  if (shape.size() == 0) {
    if (!value.is_number()) fail({where, "this is not a number", "a finite number", shown(value), ""});
    out.push_back(value.get<double>());
    return;
  }
  if (!value.is_array() || value.size() != *shape.begin())
    fail({where, "the array has the wrong shape", std::to_string(*shape.begin()) + " elements", shown(value),
          ""});
  for (const json& element : value)
    if (shape.size() == 2)
      flatten(element, {*(shape.begin() + 1)}, out, where);
    else
      flatten(element, {}, out, where);
}

std::vector<PoseRow> read_precomputed(const fs::path& folder, std::string& where) {
  where = printable((folder / "precomputed.json").string());
  const json file = read_json(folder / "precomputed.json", where);
  const auto part = [&](const char* field) -> const json& {
    if (!file.is_object() || !file.contains(field) || !file[field].is_array() || file[field].empty())
      fail({where, std::string("'") + field + "' is missing", "an array with one entry per picture",
            "no such array", ""});
    return file[field];
  };
  const json &poses = part("poses"), &bounds = part("bds");
  if (poses.size() != bounds.size())
    fail({where, "'poses' and 'bds' differ in length", std::to_string(poses.size()) + " bounds",
          std::to_string(bounds.size()), ""});
  std::vector<PoseRow> rows(poses.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<double> pose, depths;
    flatten(poses[i], {3, 5}, pose, where + ", pose " + std::to_string(i));
    flatten(bounds[i], {2}, depths, where + ", bounds " + std::to_string(i));
    std::copy(pose.begin(), pose.end(), rows[i].pose.begin());
    rows[i].near_far = {depths[0], depths[1]};
  }
  return rows;
}

/// The pictures: images, else the largest of images_2, images_4, images_8. Masks that lie among them are left
/// out.
std::vector<std::string> pictures(const fs::path& folder, const std::string& where,
                                  std::vector<std::string>& notes) {
  std::vector<std::string> others;
  for (const char* inside : {"images", "images_2", "images_4", "images_8"}) {
    if (others.empty()) others = files_in(folder / inside, FileKind::other_picture);
    std::vector<std::string> names = without_masks(files_in(folder / inside, FileKind::picture));
    if (!names.empty() && all_named_masks(names))
      notes.push_back(std::string("all pictures in ") + inside +
                      " are named as masks are: " + list_of(names));
    for (std::string& name : names) name = (fs::path(inside) / name).generic_string();
    if (names.empty()) continue;
    if (std::string(inside) != "images") notes.push_back(std::string("pictures are those of ") + inside);
    std::sort(names.begin(), names.end());  // the order in which LLFF's programs write rows
    return names;
  }
  fail({where, "there are no pictures for these cameras",
        "PNG or JPEG files in images, images_2, images_4 or images_8",
        others.empty() ? "none; in the folder: " + list_of(folders_in(folder)) : list_of(others),
        others.empty() ? "" : how_to_convert(others[0])});
}

/// One picture per camera. `rows` go with the pictures in the order of their names.
RawScene pictures_scene(const fs::path& folder, const std::vector<PoseRow>& rows, bool llff,
                        const std::string& where) {
  std::vector<std::string> notes;
  const std::vector<std::string> names = pictures(folder, where, notes);
  check_count(rows.size(), names.size(), "pictures", where);
  if (!std::is_sorted(names.begin(), names.end(), natural_less))
    notes.push_back(
        "rows are taken in the order of letters, in which programs write them, not as people count: " +
        list_of(names));
  RawSplit all{"train", where, true, {}};
  std::vector<std::array<double, 2>> depths;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.frames.push_back(frame_of_row(rows[i], llff, where + ", row " + std::to_string(i)));
    all.frames.back().file_path = names[i];
    all.frames.back().label = "row " + std::to_string(i);
    depths.push_back(rows[i].near_far);
  }
  const Box box = frusta_box(all, depths);
  all.timed = false;
  RawScene scene;
  scene.splits.push_back(std::move(all));
  scene.one_list = true;
  scene.box = box;
  scene.notes = std::move(notes);
  return scene;
}

bool has(const fs::path& folder, const char* name) {
  std::error_code ignored;
  return fs::exists(folder / name, ignored);
}

}  // namespace

std::vector<PoseRow> read_poses_bounds(const fs::path& folder, std::string& where) {
  where = printable((folder / "poses_bounds.npy").string());
  const NpyTable table = read_npy(folder / "poses_bounds.npy", where);
  if (table.columns != 17)
    fail({where, "these are no poses and bounds", "17 columns: 3 x 5 of the pose, near and far",
          std::to_string(table.columns), ""});
  std::vector<PoseRow> rows(table.rows);
  for (std::size_t i = 0; i < table.rows; ++i) {
    for (std::size_t c = 0; c < 15; ++c) rows[i].pose[c] = table.at(i, c);
    rows[i].near_far = {table.at(i, 15), table.at(i, 16)};
  }
  return rows;
}

RawFrame frame_of_row(const PoseRow& row, bool llff, const std::string& where) {
  std::array<Vec3d, 3> columns;
  for (std::size_t c = 0; c < 3; ++c) columns[c] = {row.pose[c], row.pose[5 + c], row.pose[10 + c]};
  if (llff) columns = {columns[1], -columns[0], columns[2]};
  RawFrame frame;
  set_pose(frame, matrix_of(columns, {row.pose[3], row.pose[8], row.pose[13]}), where);
  const double h = row.pose[4], w = row.pose[9], f = row.pose[14];
  if (!(h >= 1 && w >= 1 && h <= 65536 && w <= 65536))
    fail({where, "the camera's picture size is out of range", "1 to 65536 pixels a side",
          number(w) + " x " + number(h), ""});
  if (!(row.near_far[1] > row.near_far[0] && row.near_far[0] >= 0 && row.near_far[1] < 1e12))
    fail({where, "the depth bounds are out of order", "0 <= near < far",
          number(row.near_far[0]) + " and " + number(row.near_far[1]), ""});
  frame.lens.fl_x = frame.lens.fl_y = f;
  frame.lens.w = w;
  frame.lens.h = h;
  frame.lens.scaled = true;
  return frame;
}

void check_count(std::size_t cameras, std::size_t files, const char* what, const std::string& where) {
  if (cameras == files) return;
  fail({where, std::string("there are not as many ") + what + " as cameras",
        std::to_string(cameras) + ", one per row", std::to_string(files),
        "remove what does not belong, or make the poses again"});
}

bool is_llff(const fs::path& folder) { return has(folder, "poses_bounds.npy"); }
bool is_nrnerf(const fs::path& folder) { return has(folder, "precomputed.json"); }

RawScene read_llff(const fs::path& folder) {
  std::string where;
  const std::vector<PoseRow> rows = read_poses_bounds(folder, where);
  return pictures_scene(folder, rows, true, where);
}

/// NR-NeRF keeps what its loader made of the poses: the axes are turned and the world is centred already.
RawScene read_nrnerf(const fs::path& folder) {
  std::string where;
  const std::vector<PoseRow> rows = read_precomputed(folder, where);
  return pictures_scene(folder, rows, false, where);
}

}  // namespace splinevox::data
