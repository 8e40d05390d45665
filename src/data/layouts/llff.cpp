// SPDX-License-Identifier: Apache-2.0
// Cameras as rows of numbers: LLFF's poses_bounds.npy, the same with one film per camera (DyNeRF), and
// NR-NeRF's precomputed.json.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/json_file.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "data/pictures/film_read.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One camera: 3 rows of [rotation | position | height, width, focal length] and depths.
struct Row {
  std::array<double, 15> pose{};
  std::array<double, 2> near_far{};
};

/// @param llff  the rotation's columns point down, right and back; else right, up and back.
RawFrame frame_of(const Row& row, bool llff, const std::string& where) {
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

std::vector<Row> read_poses_bounds(const fs::path& folder, std::string& where) {
  where = printable((folder / "poses_bounds.npy").string());
  const NpyTable table = read_npy(folder / "poses_bounds.npy", where);
  if (table.columns != 17)
    fail({where, "these are no poses and bounds", "17 columns: 3 x 5 of the pose, near and far",
          std::to_string(table.columns), ""});
  std::vector<Row> rows(table.rows);
  for (std::size_t i = 0; i < table.rows; ++i) {
    for (std::size_t c = 0; c < 15; ++c) rows[i].pose[c] = table.at(i, c);
    rows[i].near_far = {table.at(i, 15), table.at(i, 16)};
  }
  return rows;
}

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

std::vector<Row> read_precomputed(const fs::path& folder, std::string& where) {
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
  std::vector<Row> rows(poses.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<double> pose, depths;
    flatten(poses[i], {3, 5}, pose, where + ", pose " + std::to_string(i));
    flatten(bounds[i], {2}, depths, where + ", bounds " + std::to_string(i));
    std::copy(pose.begin(), pose.end(), rows[i].pose.begin());
    rows[i].near_far = {depths[0], depths[1]};
  }
  return rows;
}

bool is_picture(const fs::path& path) {
  std::string end = path.extension().string();
  std::transform(end.begin(), end.end(), end.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return end == ".png" || end == ".jpg" || end == ".jpeg";
}

/// Paths within the folder, by name, of what `wanted` says of files in `inside`.
template <class Wanted>
std::vector<std::string> list(const fs::path& folder, const std::string& inside, const Wanted& wanted) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder / inside, error), end; !error && it != end; it.increment(error))
    if (wanted(it->path())) names.push_back((fs::path(inside) / it->path().filename()).generic_string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> films(const fs::path& folder) {
  return list(folder, "", [](const fs::path& p) {
    return p.filename().string().rfind("cam", 0) == 0 && p.extension() == ".mp4";
  });
}

/// The pictures: images, else the largest of images_2, images_4, images_8.
std::vector<std::string> pictures(const fs::path& folder, const std::string& where,
                                  std::vector<std::string>& notes) {
  for (const char* inside : {"images", "images_2", "images_4", "images_8"}) {
    std::vector<std::string> names = list(folder, inside, is_picture);
    if (names.empty()) continue;
    if (std::string(inside) != "images") notes.push_back(std::string("pictures are those of ") + inside);
    return names;
  }
  fail({where, "there are no pictures for these cameras",
        "PNG or JPEG files in images, images_2, images_4 or images_8", "none", ""});
}

void check_count(std::size_t cameras, std::size_t files, const char* what, const std::string& where) {
  if (cameras == files) return;
  fail({where, std::string("there are not as many ") + what + " as cameras",
        std::to_string(cameras) + ", one per row", std::to_string(files),
        "remove what does not belong, or make the poses again"});
}

/// One picture per camera. `rows` go with the pictures in the order of their names.
RawScene pictures_scene(const fs::path& folder, const std::vector<Row>& rows, bool llff,
                        const std::string& where) {
  std::vector<std::string> notes;
  const std::vector<std::string> names = pictures(folder, where, notes);
  check_count(rows.size(), names.size(), "pictures", where);
  RawSplit all{"train", where, true, {}};
  std::vector<std::array<double, 2>> depths;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.frames.push_back(frame_of(rows[i], llff, where + ", row " + std::to_string(i)));
    all.frames.back().file_path = names[i];
    all.frames.back().label = "row " + std::to_string(i);
    depths.push_back(rows[i].near_far);
  }
  const Box box = frusta_box(all, depths);
  all.timed = false;
  RawScene scene;
  scene.splits.push_back(std::move(all));
  scene.one_list = true;
  scene.upright = false;  // poses by COLMAP
  scene.box = box;
  scene.notes = std::move(notes);
  return scene;
}

bool has(const fs::path& folder, const char* name) {
  std::error_code ignored;
  return fs::exists(folder / name, ignored);
}

}  // namespace

bool is_llff(const fs::path& folder) { return has(folder, "poses_bounds.npy"); }
bool is_nrnerf(const fs::path& folder) { return has(folder, "precomputed.json"); }
bool is_dynerf(const fs::path& folder) { return has(folder, "poses_bounds.npy") && !films(folder).empty(); }

RawScene read_llff(const fs::path& folder) {
  std::string where;
  const std::vector<Row> rows = read_poses_bounds(folder, where);
  return pictures_scene(folder, rows, true, where);
}

/// NR-NeRF keeps what its loader made of the poses: the axes are turned and the world is centred already.
RawScene read_nrnerf(const fs::path& folder) {
  std::string where;
  const std::vector<Row> rows = read_precomputed(folder, where);
  return pictures_scene(folder, rows, false, where);
}

/// Every film is a camera that stands still, the first of them the test view. A frame's time is its time
/// stamp, in frames of the first film.
RawScene read_dynerf(const fs::path& folder) {
  std::string where;
  const std::vector<Row> rows = read_poses_bounds(folder, where);
  const std::vector<std::string> names = films(folder);
  check_count(rows.size(), names.size(), "films", where);
  RawSplit train{"train", where, true, {}}, test{"test", where, true, {}}, cameras{"train", where, true, {}};
  std::vector<std::array<double, 2>> depths;
  int fewest = 1 << 30, most = 0;
  double rate = 1;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    RawFrame frame = frame_of(rows[i], true, where + ", row " + std::to_string(i));
    frame.file_path = names[i];
    frame.label = "film " + names[i];
    cameras.frames.push_back(frame);
    depths.push_back(rows[i].near_far);
    const FilmFacts facts = film_facts(folder / names[i], printable((folder / names[i]).string()));
    if (i == 0) rate = facts.rate;
    fewest = std::min(fewest, facts.frames());
    most = std::max(most, facts.frames());
    for (frame.film_frame = 0; frame.film_frame < facts.frames(); ++frame.film_frame) {
      const double time = rate * facts.times[std::size_t(frame.film_frame)], whole = std::round(time);
      frame.time = std::abs(time - whole) < 1e-6 ? whole : time;
      frame.name = fmt::format("{}_{:04}", fs::path(names[i]).stem().string(), frame.film_frame);
      (i == 0 && rows.size() > 1 ? test : train).frames.push_back(frame);
    }
  }
  RawScene scene;
  if (fewest < most)
    scene.notes.push_back("films have from " + std::to_string(fewest) + " to " + std::to_string(most) +
                          " frames; their first frames are taken at the same time");
  scene.box = frusta_box(cameras, depths);
  scene.splits.push_back(std::move(train));
  if (!test.frames.empty()) {
    scene.notes.push_back(names[0] + " is the test split");
    scene.splits.push_back(std::move(test));
  }
  return scene;
}

}  // namespace splinevox::data
