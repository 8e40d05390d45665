// SPDX-License-Identifier: Apache-2.0
// Smoke as PINF and HyFluid ship it: info.json names films that begin together, and the volume of the smoke.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "data/file_bytes.hpp"
#include "data/json_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/rig_footage.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::array<double, 16> pose_numbers(const json& value, const std::string& name, const std::string& where) {
  const std::vector<double> m = matrix_numbers(value, 4, 4, name, where);
  std::array<double, 16> matrix{};
  std::copy(m.begin(), m.end(), matrix.begin());
  return matrix;
}

int frame_count(const json& film, const std::string& where) {
  needed_field(film, "frame_num", "how many frames of the film are used", where);
  const double count = *number_field(film, "frame_num", where);
  if (!(count >= 1 && count <= 1e6 && count == double(int(count))))
    fail(
        {where, "'frame_num' is no number of frames", "a whole number from 1 to 1000000", number(count), ""});
  return int(count);
}

/// The matrices of a film: one for each of its frames, or one for all.
std::vector<std::array<double, 16>> film_poses(const json& film, int frames, const std::string& where) {
  const auto list = film.find("transform_matrix_list");
  if (list == film.end())
    return {pose_numbers(
        needed_field(film, "transform_matrix", "4 rows of 4 numbers, or a 'transform_matrix_list'", where),
        "'transform_matrix'", where)};
  if (!list->is_array() || list->size() < std::size_t(frames))
    fail({where, "'transform_matrix_list' is too short",
          fmt::format("{} matrices, as 'frame_num' says", frames), shown(*list), ""});
  std::vector<std::array<double, 16>> poses;
  for (int i = 0; i < frames; ++i)
    poses.push_back(
        pose_numbers((*list)[std::size_t(i)], fmt::format("'transform_matrix_list' {}", i), where));
  return poses;
}

/// The lens of a film, whose size may be another than that of the camera; the shape may not.
Lens film_lens(const json& film, const std::string& where) {
  Lens lens;
  needed_field(film, "camera_angle_x", "the field of view in radians", where);
  lens.camera_angle_x = number_field(film, "camera_angle_x", where);
  const auto size = film.find("camera_hw");
  if (size == film.end()) return lens;
  const auto sane = [](const json& v) { return v.is_number() && v.get<double>() >= 1; };
  if (!size->is_array() || size->size() != 2 || !sane((*size)[0]) || !sane((*size)[1]))
    fail({where, "'camera_hw' is no size", "[height, width] in pixels", shown(*size), ""});
  lens.h = (*size)[0].get<double>();
  lens.w = (*size)[1].get<double>();
  lens.scaled = true;
  return lens;
}

/// What all films of the file have in common, as far as they were read.
struct Clock {
  double rate = 0;  ///< frames a second; 0: no film said so
  int fewest = 1 << 30, most = 0;
};

RawSplit read_films(const fs::path& folder, const json& films, const std::string& name,
                    const std::string& file, Clock& clock, std::vector<std::string>& notes) {
  RawSplit split{name, file, true, {}};
  if (!films.is_array() || films.empty())
    fail({file, fmt::format("'{}_videos' is no list of films", name), "an array of objects", shown(films),
          ""});
  for (std::size_t i = 0; i < films.size(); ++i) {
    const json& film = films[i];
    const std::string where = fmt::format("{}, '{}_videos' {}", file, name, i);
    const json& path = needed_field(film, "file_name", "a film in the folder", where);
    if (!path.is_string() || path.get_ref<const std::string&>().empty())
      fail({where, "'file_name' is not a path", "a film in the folder", shown(path), ""});
    if (const auto own = number_field(film, "frame_rate", where)) {
      if (clock.rate != 0 && *own != clock.rate)
        fail({where, "films have different frame rates", number(clock.rate) + ", as the first", number(*own),
              "make them of one rate"});
      clock.rate = *own;
    }
    const int frames = frame_count(film, where);
    clock.fewest = std::min(clock.fewest, frames);
    clock.most = std::max(clock.most, frames);
    const auto poses = film_poses(film, frames, where);
    RawFrame camera;
    camera.lens = film_lens(film, where);
    camera.camera = fs::path(path.get<std::string>()).lexically_normal().replace_extension().generic_string();
    if (!find_image(fs::canonical(folder), path.get<std::string>(), where))
      fail({where, "the film is missing", in_quotes(path.get<std::string>()), "no such file",
            "copy the films beside info.json"});
    std::vector<RawFrame> shown_frames;
    double own_rate = 0;
    const int there = add_film(folder, camera, path.get<std::string>(), own_rate, shown_frames, notes);
    if (there < frames)
      fail({where, "the film has fewer frames than 'frame_num' says", std::to_string(frames),
            std::to_string(there), "copy the film again"});
    for (int k = 0; k < frames; ++k) {
      RawFrame& frame = shown_frames[std::size_t(k)];
      frame.time = k;
      set_pose(frame, poses[poses.size() > 1 ? std::size_t(k) : 0], where);
      split.frames.push_back(std::move(frame));
    }
  }
  return split;
}

/// The volume of the smoke: a unit cube, scaled along its axes, then turned and moved by a matrix whose first
/// three columns belong to z, y and x.
std::optional<Box> volume_box(const json& file, const std::string& where) {
  const auto matrix = file.find("voxel_matrix");
  if (matrix == file.end()) return {};
  const std::vector<double> m = matrix_numbers(*matrix, 4, 4, "'voxel_matrix'", where);
  const json& scale = needed_field(file, "voxel_scale", "a number, or one along each axis", where);
  std::array<double, 3> sides{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool list = scale.is_array() && scale.size() == 3;
    const json& side = list ? scale[axis] : scale;
    if (!side.is_number() || !(side.get<double>() > 0 && side.get<double>() < 1e12))
      fail({where, "'voxel_scale' is no size", "a positive number, or one along each axis", shown(side), ""});
    sides[axis] = side.get<double>();
  }
  Box box;
  for (std::size_t row = 0; row < 3; ++row) {
    double lo = m[4 * row + 3], hi = lo;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double side = sides[axis] * m[4 * row + 2 - axis];
      (side < 0 ? lo : hi) += side;
    }
    if (!(hi > lo && std::abs(lo) < 1e12 && std::abs(hi) < 1e12))
      fail({where, "'voxel_matrix' gives no volume", "a turn, a scale and a place",
            number(lo) + " to " + number(hi) + " along an axis", ""});
    box.lo[int(row)] = float(lo);
    box.hi[int(row)] = float(hi);
  }
  return box;
}

}  // namespace

/// info.json is a common name: the one of films says so in its text, be it whole or broken.
bool is_pinf(const fs::path& folder) {
  std::error_code ignored;
  const fs::path path = folder / "info.json";
  if (!fs::is_regular_file(path, ignored)) return false;
  try {
    const std::vector<std::uint8_t> bytes = read_bytes(path, printable(path.string()), 64u << 20);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.find("\"train_videos\"") != std::string_view::npos;
  } catch (const Error&) {
    return false;  // of another program, as far as can be told
  }
}

/// Matrices are camera to world, with OpenGL's axes; all films begin at the same moment.
RawScene read_pinf(const fs::path& folder) {
  const fs::path path = folder / "info.json";
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  RawScene scene;
  Clock clock;
  for (const char* name : {"train", "val", "test"}) {
    const std::string field = std::string(name) + "_videos";
    if (name == std::string_view("train") || (file.is_object() && file.contains(field)))
      scene.splits.push_back(read_films(folder, needed_field(file, field.c_str(), "an array of films", where),
                                        name, where, clock, scene.notes));
  }
  scene.one_list = scene.splits.size() == 1;
  scene.box = volume_box(file, where);
  if (const std::string note = note_on_lengths(clock.fewest, clock.most); !note.empty())
    scene.notes.push_back(note);
  return scene;
}

}  // namespace splinevox::data
