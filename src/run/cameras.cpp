// SPDX-License-Identifier: Apache-2.0
#include "splinevox/run/cameras.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "core/json_text.hpp"
#include "core/nearest.hpp"
#include "data/camera_check.hpp"
#include "data/json_file.hpp"
#include "data/layouts/axes.hpp"
#include "data/layouts/near_miss.hpp"
#include "data/layouts/transforms.hpp"
#include "run/camera_ways.hpp"
#include "run/support.hpp"
#include "run/training_cameras.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

using FileJson = nlohmann::json;

constexpr int kOrbitShots = 60;
constexpr const char* kDataWay = "transforms_render.json";

using Note = std::function<void(const std::string&)>;

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

/// Where shots 0 to count - 1 are on a way. @param closed  the end is the beginning, and not shown twice
std::vector<double> evenly(int count, bool closed) {
  std::vector<double> at;
  for (int i = 0; i < count; ++i) at.push_back(double(i) / std::max(1, closed ? count : count - 1));
  return at;
}

/// Cameras with times that go evenly from first to last.
std::vector<Shot> timed(const std::vector<Camera>& cameras, double first = 0, double last = 1) {
  std::vector<Shot> shots;
  const std::vector<double> at = evenly(int(cameras.size()), false);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    shots.push_back({cameras[i], first + (last - first) * at[i]});
  return shots;
}

std::vector<Shot> orbit_shots(const Run& run, const CameraRequest& request, int count) {
  return timed(orbit(run.model.box, request.elevation, request.size > 0 ? request.size : 400,
                     count > 0 ? count : kOrbitShots));
}

/// The camera with a picture of another width and the same shape.
Camera resized(Camera c, int width) {
  const double scale = double(width) / c.width;
  c.width = width;
  c.height = std::max(1, int(std::lround(c.height * scale)));
  for (double* v : {&c.fx, &c.fy, &c.cx, &c.cy}) *v *= scale;
  return c;
}

/// Shots with pictures of that width; 0: of their own.
void resize(std::vector<Shot>& shots, int width) {
  for (Shot& s : shots)
    if (width > 0) s.camera = resized(s.camera, width);
}

std::vector<Camera> cameras_of(const std::vector<Shot>& shots) {
  std::vector<Camera> out;
  for (const Shot& s : shots) out.push_back(s.camera);
  return out;
}

/// A way by the training cameras. @param times  how many shots it has; 0: as many as suit it
std::vector<Shot> way(const TrainingCameras& train, const CameraRequest& request, const std::string& name,
                      int times, const Note& note) {
  const bool film = !train.film.empty();
  const int count = times > 0 ? times : film && name != "held" ? std::min(int(train.film.size()), 600) : 60;
  std::vector<Shot> shots;
  if (name == "held") {
    shots = timed(std::vector<Camera>(std::size_t(count), central(train.places).camera));
  } else if (name == "stabilised") {
    if (!film)
      fail({"--camera", "the training pictures are no film of one camera: there is no way to smooth",
            "pictures of one camera, 8 or more, each near the one before", name,
            "--camera interpolate, spiral or held"});
    note(fmt::format("stabilised: each camera is a line fitted to {:.0f}% of the film, about {:.0f} pictures",
                     100 * request.window, std::max(5.0, request.window * double(train.film.size()))));
    const double first = train.film.front().time, last = train.film.back().time;
    shots = last > first ? timed(stabilised(train.film, request.window, evenly(count, false)), first, last)
                         : timed(stabilised(train.film, request.window, evenly(count, false)));
  } else if (train.places.size() < 2) {
    fail({"--camera", "all training pictures were taken from one place: there is no way between them",
          "two places or more", name, "--camera held, or orbit"});
  } else if (name == "interpolate" && film) {
    shots = timed(interpolated(cameras_of(train.film), train.middle, false, evenly(count, false)));
  } else if (name == "interpolate") {
    std::vector<Camera> trip = round_trip(cameras_of(train.places), kFewPlaces);
    const bool open = open_at_wide_leg(trip, train.middle);
    std::vector<double> at = evenly(count, true);
    for (double& t : at)
      if (open) t = 1 - std::abs(2 * t - 1);  // there and back
    shots = timed(interpolated(trip, train.middle, !open, at));
  } else {
    shots = timed(spiral(cameras_of(train.places), train.middle, evenly(count, true)));
  }
  resize(shots, request.size);
  return shots;
}

const char* way_for(Stand stand) {
  switch (stand) {
    case Stand::around:
      return "orbit";
    case Stand::film:
      return "stabilised";
    case Stand::few:
      return "interpolate";
    case Stand::many:
      return "spiral";
    case Stand::one:
      return "held";
  }
  return "";
}

/// What suits the training cameras. Where those cannot be read the orbit, which needs none, is said to be a
/// makeshift.
std::vector<Shot> suitable(const Run& run, const CameraRequest& request, int times, const Note& note) {
  std::optional<TrainingCameras> train;
  try {
    train = training_cameras(run, request.data, request.elevation);
  } catch (const Error& e) {
    note(fmt::format("--camera orbit, for want of the training cameras (--data names their data set): {}",
                     e.what()));
  }
  if (train) note(fmt::format("--camera {}: {}", way_for(train->stand), train->why));
  if (!train || train->stand == Stand::around) return orbit_shots(run, request, times);
  return way(*train, request, way_for(train->stand), times, note);
}

/// Times outside the run's show its first or last moment. @param own  whether shots keep these times
void hold_times(std::vector<Shot>& shots, bool own, const Note& note) {
  constexpr double kRounding = 1e-6;
  std::size_t outside = 0;
  for (Shot& s : shots) {
    outside += s.time < -kRounding || s.time > 1 + kRounding ? 1 : 0;
    s.time = std::clamp(s.time, 0.0, 1.0);
  }
  if (own && outside > 0)
    note(fmt::format("{} of {} cameras have times outside the run's: they show its first or last moment",
                     outside, shots.size()));
}

/// Whether shots are to have the times that cameras come with.
bool keeps_times(const CameraRequest& request) { return request.times.empty() && request.moments.empty(); }

std::vector<Shot> from_dataset(const Run& run, const CameraRequest& request, const Note& note) {
  const std::vector<std::string> parts = split_list(request.camera, ':');
  const std::string split = parts.size() > 1 ? parts[1] : "test";
  const Dataset data = open_split(run, request.data, split, {}, Pixels::left_out);
  std::vector<Shot> shots;
  for (const Frame& f : data.find(split)->frames) shots.push_back({f.camera, f.time});
  resize(shots, request.size);
  if (parts.size() > 2) {
    const std::vector<double> index = numbers(parts[2], ',', "--camera", "dataset:SPLIT:INDEX");
    if (index.size() != 1 || index[0] < 0 || index[0] >= double(shots.size()) ||
        index[0] != std::floor(index[0]))
      fail({"--camera", fmt::format("the {} split has no frame {}", split, parts[2]),
            fmt::format("a number in [0, {}]", shots.size() - 1), request.camera, ""});
    shots = {shots[std::size_t(index[0])]};
  }
  hold_times(shots, keeps_times(request), note);
  return shots;
}

/// @param matrix  camera to world, row by row
Shot shot_of(const FileJson& frame, const std::array<double, 16>& matrix, const data::Lens& file_lens,
             const CameraRequest& request, const TimeMap& map, const std::string& where) {
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
    s.time = map(frame["time"].get<double>());
  }
  return s;
}

struct FileShots {
  std::vector<Shot> shots;
  std::map<int, Camera> numbered;  ///< empty unless there are several, each with a number of its own
};

/// @param own_times  whether shots are to have the file's times
FileShots from_file(const Run& run, const CameraRequest& request, const std::string& path, bool own_times,
                    const Note& note) {
  const FileJson file = data::read_json(path, path);
  const FileJson frames = file.is_object() && file.contains("frames")
                              ? file["frames"]
                              : FileJson::array({file});  // one camera alone is a frame too
  if (!frames.is_array() || frames.empty() ||
      (!file.contains("frames") && !(file.is_object() && file.contains("transform_matrix"))))
    fail({path, "there are no frames in this file",
          "the layout of transforms_train.json: camera_angle_x or fl_x, frames with transform_matrix", "",
          ""});
  const data::Lens lens = data::read_lens(file, path);
  data::UnreadFields unread;
  unread.look_at(file);
  for (const FileJson& frame : frames) unread.look_at(frame);
  const auto where = [&](std::size_t i) { return fmt::format("{}, frame {}", path, i); };
  std::vector<std::array<double, 16>> matrices;
  std::size_t timed = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FileJson& frame = frames[i];
    if (!frame.is_object())
      fail({where(i), "this is not a frame", "an object with transform_matrix",
            dump_json(frame).substr(0, 60), ""});
    timed += frame.contains("time") ? 1 : 0;
    matrices.push_back(data::read_matrix(frame, where(i), unread));
  }
  if (own_times && timed > 0 && timed < frames.size())
    fail({path, "some frames have no 'time'", "a finite number in each frame, or in none",
          fmt::format("{} of {} frames with 'time'", timed, frames.size()),
          "give every frame a time, or none"});
  for (const std::string& line : unread.notes(path)) note(line);
  if (const std::string text = data::take_last_rows(matrices); !text.empty()) note(path + ": " + text);
  FileShots out;
  std::vector<Shot>& shots = out.shots;
  for (std::size_t i = 0; i < frames.size(); ++i)
    shots.push_back(shot_of(frames[i], matrices[i], lens, request, run.record.time_map, where(i)));
  resize(shots, request.size);
  hold_times(shots, own_times, note);
  for (std::size_t i = 0; timed == 0 && i < shots.size() && shots.size() > 1; ++i)
    shots[i].time = double(i) / double(shots.size() - 1);
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].contains("frame") && frames[i]["frame"].is_number_integer())
      out.numbered.try_emplace(frames[i]["frame"].get<int>(), shots[i].camera);
  if (out.numbered.size() < std::max(shots.size(), std::size_t(2))) out.numbered.clear();
  return out;
}

bool names_file(const std::string& camera) {
  const std::vector<std::string> ways = camera_ways();
  std::error_code ignored;
  return std::find(ways.begin(), ways.end(), camera) == ways.end() && camera != "dataset" &&
         !camera.starts_with("dataset:") &&
         (camera.ends_with(".json") || std::filesystem::exists(camera, ignored));
}

std::vector<std::string> known_cameras() {
  std::vector<std::string> names = camera_ways();
  names.push_back("dataset:test");
  return names;
}

/// The way that the data set itself brings.
std::vector<Shot> of_data(const Run& run, const CameraRequest& request, const Note& note) {
  const std::string path =
      (std::filesystem::path(request.data.empty() ? run.record.dataset : request.data) / kDataWay).string();
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    fail({"--camera", "the data set brings no way of its own",
          fmt::format("{} in its folder, laid out as transforms_train.json", kDataWay), path,
          "--camera FILE for cameras of yours"});
  return from_file(run, request, path, keeps_times(request), note).shots;
}

}  // namespace

std::vector<std::string> camera_ways() {
  return {"auto", "orbit", "stabilised", "interpolate", "spiral", "held", "data"};
}

std::vector<Shot> plan_shots(const Run& run, const CameraRequest& request,
                             const std::function<void(const std::string&)>& on_note) {
  const Note note = [&](const std::string& line) {
    if (on_note) on_note(line);
  };
  if (!(std::abs(request.elevation) < 90))
    fail({"elevation", "there is no such elevation", "degrees between -90 and 90",
          fmt::format("{:g}", request.elevation), ""});
  if (!(request.window > 0 && request.window <= 1))
    fail({"window", "there is no such share of the film", "more than 0, at most 1",
          fmt::format("{:g}", request.window), ""});
  const std::string& c = request.camera;
  const std::vector<double> times = request.times.empty() ? request.moments : parse_times(request.times);
  const int count = int(times.size());
  std::vector<Shot> shots;
  if (c == "auto")
    shots = suitable(run, request, count, note);
  else if (c == "orbit")
    shots = orbit_shots(run, request, count);
  else if (c == "stabilised" || c == "interpolate" || c == "spiral" || c == "held")
    shots = way(training_cameras(run, request.data, request.elevation), request, c, count, note);
  else if (c == "data")
    shots = of_data(run, request, note);
  else if (c == "dataset" || c.starts_with("dataset:"))
    shots = from_dataset(run, request, note);
  else if (names_file(c))
    shots = from_file(run, request, c, keeps_times(request), note).shots;
  else
    fail({"--camera", "there is no such camera",
          fmt::format("{}, dataset:SPLIT, dataset:SPLIT:INDEX or a transforms file",
                      fmt::join(camera_ways(), ", ")),
          c, "--camera " + nearest(c, known_cameras())});
  if (times.empty()) return shots;
  std::vector<Shot> planned;
  for (std::size_t i = 0; i < times.size(); ++i)
    planned.push_back({shots[i * shots.size() / times.size()].camera, times[i]});
  return planned;
}

std::map<int, Camera> numbered_cameras(const Run& run, const CameraRequest& request,
                                       const std::function<void(const std::string&)>& on_note) {
  if (!names_file(request.camera)) return {};
  std::vector<std::string> notes;
  std::map<int, Camera> cameras =
      from_file(run, request, request.camera, false, [&](const std::string& line) {
        notes.push_back(line);
      }).numbered;
  if (!cameras.empty() && on_note) std::for_each(notes.begin(), notes.end(), on_note);
  return cameras;
}

}  // namespace splinevox::run
