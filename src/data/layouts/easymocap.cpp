// SPDX-License-Identifier: Apache-2.0
// EasyMocap's calibration: intri.yml and extri.yml of OpenCV, a pose and a lens for each named camera.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "data/layouts/folder_list.hpp"
#include "data/layouts/opencv_yaml.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/rig_footage.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// One of the two files.
struct Calibration {
  std::string where;
  std::map<std::string, StorageValue> values;

  Calibration(const fs::path& folder, const char* name)
      : where(printable((folder / name).string())), values(read_opencv_yaml(folder / name, where)) {}

  std::string at(const StorageValue& value) const { return fmt::format("{}, line {}", where, value.line); }

  const StorageValue* find(const std::string& key) const {
    const auto found = values.find(key);
    return found == values.end() ? nullptr : &found->second;
  }

  /// The numbers of a matrix that must have one of the shapes; columns may lie as rows. Empty if there is
  /// none.
  std::vector<double> matrix(const std::string& key, std::initializer_list<std::size_t> counts,
                             const char* shape) const {
    const StorageValue* value = find(key);
    if (!value) return {};
    const bool fits =
        value->kind == StorageValue::Kind::matrix &&
        std::find(counts.begin(), counts.end(), value->numbers.size()) != counts.end() &&
        (value->numbers.size() == 9 ? value->rows == 3 : std::min(value->rows, value->columns) == 1);
    if (!fits)
      fail({at(*value), in_quotes(key) + " has the wrong shape", shape,
            value->kind == StorageValue::Kind::matrix ? fmt::format("{} x {}", value->rows, value->columns)
                                                      : "no matrix",
            ""});
    for (const double number_of_it : value->numbers)
      if (!(std::abs(number_of_it) <= 1e12))
        fail({at(*value), in_quotes(key) + " holds a number that is not finite or too large", "at most 1e12",
              number(number_of_it), ""});
    return value->numbers;
  }

  std::vector<double> needed_matrix(const std::string& key, std::initializer_list<std::size_t> counts,
                                    const char* shape) const {
    std::vector<double> numbers = matrix(key, counts, shape);
    if (numbers.empty()) fail({where, in_quotes(key) + " is missing", shape, "no such key", ""});
    return numbers;
  }

  std::vector<std::string> names() const {
    const StorageValue* value = find("names");
    if (!value) fail({where, "'names' is missing", "a list of the cameras' names", "no such key", ""});
    if (value->kind != StorageValue::Kind::list || value->texts.empty())
      fail({at(*value), "'names' is no list of cameras", "at least one name", "none", ""});
    std::vector<std::string> sorted = value->texts;
    std::sort(sorted.begin(), sorted.end());
    if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
      fail({at(*value), "'names' has a camera twice", "each camera once", in_quotes(*twice), ""});
    for (const std::string& name : sorted)
      if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos)
        fail({at(*value), "'names' holds what is no name of a folder", "as in images/NAME", in_quotes(name),
              ""});
    return value->texts;
  }
};

/// The rows of a rotation by its axis, as long as its angle in radians (Rodrigues).
std::array<Vec3d, 3> rows_of_axis(const Vec3d& axis) {
  const double angle = length(axis);
  if (angle < 1e-12) return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Vec3d u = (1 / angle) * axis;
  const double c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  return {{{c + d * u.x * u.x, d * u.x * u.y - s * u.z, d * u.x * u.z + s * u.y},
           {d * u.x * u.y + s * u.z, c + d * u.y * u.y, d * u.y * u.z - s * u.x},
           {d * u.x * u.z - s * u.y, d * u.y * u.z + s * u.x, c + d * u.z * u.z}}};
}

std::array<Vec3d, 3> rows_of_numbers(const std::vector<double>& n) {
  if (n.size() == 3) return rows_of_axis({n[0], n[1], n[2]});
  return {{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}}};
}

/// Rot_NAME is a matrix and R_NAME an axis, as a rule; where both are there, they must agree.
std::array<Vec3d, 3> rotation_of(const Calibration& file, const std::string& name) {
  constexpr const char* kShape = "a rotation: 3 x 3, or an axis of 3 numbers";
  const std::vector<double> matrix = file.matrix("Rot_" + name, {9, 3}, kShape),
                            axis = matrix.empty() ? file.needed_matrix("R_" + name, {9, 3}, kShape)
                                                  : file.matrix("R_" + name, {9, 3}, kShape);
  if (matrix.empty()) return rows_of_numbers(axis);
  const std::array<Vec3d, 3> rows = rows_of_numbers(matrix);
  if (axis.empty()) return rows;
  const std::array<Vec3d, 3> same = rows_of_numbers(axis);
  for (std::size_t row = 0; row < 3; ++row)
    if (!(length(rows[row] - same[row]) < 1e-3))
      fail({file.where, fmt::format("'Rot_{0}' and 'R_{0}' are different rotations", printable(name)),
            "one of them, or both the same", "rows that differ by " + number(length(rows[row] - same[row])),
            ""});
  return rows;
}

constexpr double kFirstCentre = 0.5;  ///< of the first pixel, where OpenCV's calibration has 0

Lens lens_of_camera(const Calibration& file, const std::string& name) {
  const std::vector<double> k = file.needed_matrix("K_" + name, {9}, "a lens: 3 x 3");
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1 || std::abs(k[1]) > 1e-6 * std::abs(k[0]))
    fail({file.at(*file.find("K_" + name)), in_quotes("K_" + name) + " is no matrix of a lens without skew",
          "fx 0 cx, 0 fy cy, 0 0 1", "other numbers in the places of 0 and 1",
          "undistort the pictures first"});
  Lens lens;
  lens.fl_x = k[0];
  lens.fl_y = k[4];
  lens.cx = k[2] + kFirstCentre;
  lens.cy = k[5] + kFirstCentre;
  constexpr const char* kShape = "k1 k2 p1 p2, and k3 if there is one";
  const bool old = !file.find("dist_" + name);
  std::vector<double> bent = file.matrix((old ? "D_" : "dist_") + name, {4, 5, 8, 12, 14}, kShape);
  if (std::any_of(bent.begin() + std::ptrdiff_t(std::min<std::size_t>(bent.size(), 5)), bent.end(),
                  [](double d) { return d != 0; }))
    fail({file.where, "the distortion of camera " + in_quotes(name) + " is not supported", kShape,
          fmt::format("{} numbers", bent.size()), "undistort the pictures first"});
  bent.resize(5);
  lens.k1 = bent[0];
  lens.k2 = bent[1];
  lens.p1 = bent[2];
  lens.p2 = bent[3];
  lens.k3 = bent[4];
  const StorageValue *high = file.find("H_" + name), *wide = file.find("W_" + name);
  if (!high || !wide) return lens;
  for (const StorageValue* side : {high, wide})
    if (side->kind != StorageValue::Kind::text || !(storage_number(side->texts[0]) >= 1))
      fail({file.at(*side), "the size of camera " + in_quotes(name) + " is no size", "a number of pixels",
            side->kind == StorageValue::Kind::text ? in_quotes(side->texts[0]) : "no number", ""});
  lens.h = storage_number(high->texts[0]);
  lens.w = storage_number(wide->texts[0]);
  lens.scaled = true;
  return lens;
}

void check_same_names(const Calibration& lenses, const Calibration& poses) {
  const std::vector<std::string> ours = lenses.names(), theirs = poses.names();
  for (const std::string& name : ours)
    if (std::find(theirs.begin(), theirs.end(), name) == theirs.end())
      fail({poses.where, "a camera has a lens and no pose", "all names of intri.yml", in_quotes(name), ""});
  for (const std::string& name : theirs)
    if (std::find(ours.begin(), ours.end(), name) == ours.end())
      fail({lenses.where, "a camera has a pose and no lens", "all names of extri.yml", in_quotes(name), ""});
}

}  // namespace

bool is_easymocap(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "intri.yml", ignored) || fs::exists(folder / "extri.yml", ignored);
}

/// Rotations and translations are world to camera, with OpenCV's axes.
RawScene read_easymocap(const fs::path& folder) {
  const Calibration lenses(folder, "intri.yml"), poses(folder, "extri.yml");
  check_same_names(lenses, poses);
  const std::vector<std::string> names = poses.names();
  RawScene scene;
  scene.one_list = true;
  scene.splits.push_back({"train", poses.where, false, {}});
  for (const std::string& name : names) {
    const std::vector<double> t = poses.needed_matrix("T_" + name, {3}, "a translation: 3 x 1");
    RawFrame camera;
    camera.camera = name;
    camera.label = "camera " + printable(name);
    camera.lens = lens_of_camera(lenses, name);
    set_pose(camera, matrix_of_opencv(rotation_of(poses, name), {t[0], t[1], t[2]}),
             poses.where + ", " + camera.label);
    scene.splits[0].frames.push_back(std::move(camera));
  }
  const std::vector<Footage> footage = find_footage(folder, names);
  if (footage.empty())
    fail({poses.where, "there are no pictures of these cameras",
          "images/NAME/000000.jpg or videos/NAME.mp4 for " + list_of(names), list_of(folders_in(folder)),
          "copy the pictures beside the calibration"});
  take_footage(folder, footage, scene);
  return scene;
}

}  // namespace splinevox::data
