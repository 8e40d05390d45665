// SPDX-License-Identifier: Apache-2.0
// Dynamic 3D Gaussians: train_meta.json and test_meta.json, a table of moments and cameras.
#include <fmt/format.h>

#include <array>
#include <map>
#include <set>

#include "data/json_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path meta_file(const fs::path& folder, const std::string& split) {
  return folder / (split + "_meta.json");
}

/// One of the file's tables: an array per moment, with an entry per camera.
class FieldTable {
 public:
  FieldTable(const json& file, const char* field, const std::string& where)
      : field_(field), where_(where), rows_(needed_field(file, field, kShape, where)) {
    if (!rows_.is_array() || rows_.empty())
      fail({where, fmt::format("'{}' is no table", field), kShape, shown(rows_), ""});
    for (const json& row : rows_)
      if (!row.is_array() || row.empty())
        fail({where, fmt::format("'{}' is no table", field), kShape, "a moment that is " + shown(row), ""});
  }
  std::size_t moments() const { return rows_.size(); }
  std::size_t cameras(std::size_t moment) const { return rows_[moment].size(); }
  const json& at(std::size_t moment, std::size_t camera) const { return rows_[moment][camera]; }

  /// Refuses another shape than that of the table of file names.
  void check_shape(const FieldTable& names) const {
    if (moments() != names.moments())
      fail({where_, fmt::format("'{}' and 'fn' have different numbers of moments", field_),
            std::to_string(names.moments()), std::to_string(moments()), ""});
    for (std::size_t t = 0; t < moments(); ++t)
      if (cameras(t) != names.cameras(t))
        fail({where_, fmt::format("'{}' and 'fn' have different numbers of cameras at moment {}", field_, t),
              std::to_string(names.cameras(t)), std::to_string(cameras(t)), ""});
  }

 private:
  static constexpr const char* kShape = "an array per moment, with an entry per camera";
  const char* field_;
  const std::string& where_;
  const json& rows_;
};

std::string camera_id(const json& value, const std::string& where) {
  if (value.is_number_integer()) return value.dump();
  if (value.is_string() && !value.get_ref<const std::string&>().empty()) return value.get<std::string>();
  fail({where, "'cam_id' is no name of a camera", "a whole number or a text", shown(value), ""});
}

Lens lens_of_matrix(const json& k, const Lens& size, const std::string& where) {
  const std::vector<double> m = matrix_numbers(k, 3, 3, "'k'", where);
  if (m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
    fail({where, "'k' is no matrix of a lens", "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
          fmt::format("[..], [{}, .., ..], [{}, {}, {}]", number(m[3]), number(m[6]), number(m[7]),
                      number(m[8])),
          ""});
  if (std::abs(m[1]) > 1e-6 * std::abs(m[0]))
    fail({where, "'k' has skew", "0 in its first row", number(m[1]), "undistort the pictures first"});
  Lens lens = size;
  lens.fl_x = m[0];
  lens.fl_y = m[4];
  lens.cx = m[2];
  lens.cy = m[5];
  return lens;
}

void set_pose_of(RawFrame& frame, const json& w2c, const std::string& where) {
  const std::vector<double> m = matrix_numbers(w2c, 4, 4, "'w2c'", where);
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    fail({where, "'w2c' does not end in 0 0 0 1", "a rigid matrix, world to camera",
          fmt::format("{} {} {} {}", number(m[12]), number(m[13]), number(m[14]), number(m[15])), ""});
  const std::array<Vec3d, 3> rows{{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}};
  set_pose(frame, matrix_of_opencv(rows, {m[3], m[7], m[11]}), where);
}

RawSplit read_meta(const fs::path& folder, const std::string& name) {
  const fs::path path = meta_file(folder, name);
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  RawSplit split{name, where, true, {}};
  const FieldTable names(file, "fn", where), lenses(file, "k", where), poses(file, "w2c", where),
      ids(file, "cam_id", where);
  for (const FieldTable* table : {&lenses, &poses, &ids}) table->check_shape(names);
  Lens size;
  for (const char* field : {"w", "h"}) {
    needed_field(file, field, "the pictures' size in pixels", where);
    (field[0] == 'w' ? size.w : size.h) = number_field(file, field, where);
  }
  for (std::size_t t = 0; t < names.moments(); ++t) {
    std::set<std::string> seen;
    for (std::size_t c = 0; c < names.cameras(t); ++c) {
      RawFrame frame;
      frame.label = fmt::format("moment {}, camera {}", t, c);
      const std::string at = where + ", " + frame.label;
      const json& fn = names.at(t, c);
      if (!fn.is_string() || fn.get_ref<const std::string&>().empty())
        fail({at, "'fn' is not a path", "the picture's path within ims", shown(fn), ""});
      const fs::path picture(fn.get<std::string>());
      frame.file_path = (fs::path("ims") / picture).generic_string();
      frame.camera = camera_id(ids.at(t, c), at);
      if (!seen.insert(frame.camera).second)
        fail(
            {at, "'cam_id' is there twice at this moment", "every camera once", in_quotes(frame.camera), ""});
      frame.time = double(t);
      frame.lens = lens_of_matrix(lenses.at(t, c), size, at);
      frame.name = frame.camera + "_" + picture.stem().string();
      set_pose_of(frame, poses.at(t, c), at);
      const fs::path mask = fs::path("seg") / fs::path(picture).replace_extension(".png");
      std::error_code ignored;
      if (fs::is_regular_file(folder / mask, ignored)) frame.mask = mask.generic_string();
      split.frames.push_back(std::move(frame));
    }
  }
  return split;
}

double last_moment(const RawSplit& split) { return split.frames.back().time; }

/// A camera that both files have would be judged by pictures that it was trained on.
void check_files(const RawSplit& train, const RawSplit& test, std::vector<std::string>& notes) {
  std::set<std::pair<std::string, double>> trained;
  for (const RawFrame& frame : train.frames) trained.emplace(frame.camera, frame.time);
  for (const RawFrame& frame : test.frames)
    if (trained.contains({frame.camera, frame.time}))
      fail({test.file, "a camera of the test split is one of the train split", "cameras of its own",
            "'cam_id' " + in_quotes(frame.camera) + " of moment " + number(frame.time), ""});
  if (last_moment(train) != last_moment(test))
    notes.push_back(
        fmt::format("the train split has {} moments and the test split {}: the first of both is the "
                    "same moment",
                    last_moment(train) + 1, last_moment(test) + 1));
}

}  // namespace

bool is_dynamic_gaussians(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(meta_file(folder, "train"), ignored);
}

/// Matrices are world to camera, with OpenCV's axes; a moment's number is its time.
RawScene read_dynamic_gaussians(const fs::path& folder) {
  RawScene scene;
  scene.splits.push_back(read_meta(folder, "train"));
  std::error_code ignored;
  scene.one_list = !fs::exists(meta_file(folder, "test"), ignored);
  if (!scene.one_list) {
    scene.splits.push_back(read_meta(folder, "test"));
    check_files(scene.splits[0], scene.splits[1], scene.notes);
  }
  return scene;
}

}  // namespace splinevox::data
