// SPDX-License-Identifier: Apache-2.0
#include "splinevox/run/cameras.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/json_text.hpp"
#include "core/nearest.hpp"
#include "data/camera_check.hpp"
#include "data/json_file.hpp"
#include "data/layouts/transforms.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

using FileJson = nlohmann::json;

constexpr double kOrbitView = 36;  // degrees of full horizontal view
constexpr int kOrbitShots = 60;

std::vector<double> parse_times(const std::string& text) {
  const char* expected = "T, or A:B:N with N >= 1: N times from A to B in the model's 0..1";
  const std::vector<double> v = numbers(text, ':', "--times", expected);
  if (v.size() == 1 && v[0] >= 0 && v[0] <= 1) return v;
  if (v.size() != 3 || v[2] < 1 || v[2] > 1e6 || v[2] != std::floor(v[2]))
    fail({"--times", "this is not a range of times", expected, text, "--times 0:1:60"});
  if (std::min(v[0], v[1]) < 0 || std::max(v[0], v[1]) > 1)
    fail({"--times", "there is no such time in the model",
          "times from 0, the first moment of the training pictures, to 1, the last", text, "--times 0:1:60"});
  std::vector<double> times;
  for (int i = 0; i < int(v[2]); ++i)
    times.push_back(v[2] > 1 ? v[0] + (v[1] - v[0]) * i / (v[2] - 1) : v[0]);
  return times;
}

/// Round the middle of the box once, z upwards, far enough that all of the box is visible.
std::vector<Shot> orbit(const VoxelModel& model, const CameraRequest& request, int count) {
  const int size = request.size > 0 ? request.size : 400;
  const double half = kOrbitView / 2 * std::numbers::pi / 180,
               up = request.elevation * std::numbers::pi / 180;
  const Vec3d centre = cast<double>(model.box.center());
  const double distance = 0.5 * length(cast<double>(model.box.extent())) / std::sin(half);
  std::vector<Shot> shots;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * i / count;
    const Vec3d out{std::cos(up) * std::cos(a), std::cos(up) * std::sin(a), std::sin(up)};
    Shot s;
    s.camera.width = s.camera.height = size;
    s.camera.fx = s.camera.fy = 0.5 * size / std::tan(half);
    s.camera.cx = s.camera.cy = 0.5 * size;
    const Vec3d right{-std::sin(a), std::cos(a), 0};
    s.camera.axes = {right, cross(out, right), out};
    s.camera.position = centre + distance * out;
    s.time = count > 1 ? double(i) / (count - 1) : 0;
    shots.push_back(s);
  }
  return shots;
}

std::vector<Shot> from_dataset(const Run& run, const CameraRequest& request) {
  const std::vector<std::string> parts = split_list(request.camera, ':');
  const std::string split = parts.size() > 1 ? parts[1] : "test";
  const Dataset data = open_split(run, request.data, split);
  std::vector<Shot> shots;
  for (const Frame& f : data.find(split)->frames) shots.push_back({f.camera, std::clamp(f.time, 0.0, 1.0)});
  if (parts.size() < 3) return shots;
  const std::vector<double> index = numbers(parts[2], ',', "--camera", "dataset:SPLIT:INDEX");
  if (index.size() != 1 || index[0] < 0 || index[0] >= double(shots.size()) ||
      index[0] != std::floor(index[0]))
    fail({"--camera", fmt::format("the {} split has no frame {}", split, parts[2]),
          fmt::format("a number in [0, {}]", shots.size() - 1), request.camera, ""});
  return {shots[std::size_t(index[0])]};
}

Shot shot_of(const FileJson& frame, const data::Lens& file_lens, const CameraRequest& request,
             const TimeMap& map, const std::string& where) {
  const FileJson rows = frame.contains("transform_matrix") ? frame["transform_matrix"] : FileJson();
  std::array<double, 16> matrix{};
  bool good = rows.is_array() && rows.size() == 4;
  for (std::size_t r = 0; good && r < 4; ++r) {
    good = rows[r].is_array() && rows[r].size() == 4;
    for (std::size_t c = 0; good && c < 4; ++c) {
      good = rows[r][c].is_number();
      matrix[4 * r + c] = good ? rows[r][c].get<double>() : 0;
    }
  }
  if (!good)
    fail({where, "'transform_matrix' is not a matrix", "4 rows of 4 numbers, camera to world", "", ""});
  const data::Lens lens = data::merge(file_lens, data::read_lens(frame, where));
  const double wide = lens.w.value_or(request.size > 0 ? request.size : 400), high = lens.h.value_or(wide);
  if (!(wide >= 1 && high >= 1 && wide <= 16384 && high <= 16384))
    fail({where, "'w' and 'h' are not a picture's size", "1 to 16384 pixels",
          fmt::format("{} x {}", wide, high), ""});
  const int width = int(wide), height = int(high);
  Shot s;
  s.camera = data::pinhole(lens, data::rigid_pose(matrix, where), width, height, where);
  if (frame.contains("time")) {
    if (!frame["time"].is_number())
      fail(
          {where, "'time' is not a number", "a number in the data's own time", dump_json(frame["time"]), ""});
    s.time = std::clamp(map(frame["time"].get<double>()), 0.0, 1.0);
  }
  return s;
}

std::vector<Shot> from_file(const Run& run, const CameraRequest& request) {
  const FileJson file = data::read_json(request.camera, request.camera);
  const FileJson frames = file.is_object() && file.contains("frames")
                              ? file["frames"]
                              : FileJson::array({file});  // one camera alone is a frame too
  if (!frames.is_array() || frames.empty() ||
      (!file.contains("frames") && !(file.is_object() && file.contains("transform_matrix"))))
    fail({request.camera, "there are no frames in this file",
          "the layout of transforms_train.json: camera_angle_x or fl_x, frames with transform_matrix", "",
          ""});
  const data::Lens lens = data::read_lens(file, request.camera);
  std::vector<Shot> shots;
  bool timed = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string where = fmt::format("{}, frame {}", request.camera, i);
    const FileJson& frame = frames[i];
    if (!frame.is_object())
      fail({where, "this is not a frame", "an object with transform_matrix", dump_json(frame).substr(0, 60),
            ""});
    timed = timed || frame.contains("time");
    shots.push_back(shot_of(frame, lens, request, run.record.time_map, where));
  }
  for (std::size_t i = 0; !timed && i < shots.size() && shots.size() > 1; ++i)
    shots[i].time = double(i) / double(shots.size() - 1);
  return shots;
}

}  // namespace

std::vector<Shot> plan_shots(const Run& run, const CameraRequest& request) {
  const std::string& c = request.camera;
  const std::vector<double> times =
      request.times.empty() ? std::vector<double>{} : parse_times(request.times);
  std::error_code ignored;
  std::vector<Shot> shots;
  if (c == "orbit")
    shots = orbit(run.model, request, times.empty() ? kOrbitShots : int(times.size()));
  else if (c == "dataset" || c.rfind("dataset:", 0) == 0)
    shots = from_dataset(run, request);
  else if (c.ends_with(".json") || std::filesystem::exists(c, ignored))
    shots = from_file(run, request);
  else
    fail({"--camera", "there is no such camera",
          "orbit, dataset:SPLIT, dataset:SPLIT:INDEX or a transforms file", c,
          "--camera " + nearest(c, {"orbit", "dataset:test"})});
  if (times.empty()) return shots;
  std::vector<Shot> planned;
  for (std::size_t i = 0; i < times.size(); ++i)
    planned.push_back({shots[i * shots.size() / times.size()].camera, times[i]});
  return planned;
}

}  // namespace splinevox::run
