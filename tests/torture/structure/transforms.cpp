// SPDX-License-Identifier: Apache-2.0
// transforms files: D-NeRF, nerfstudio, NeRFlow.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

using json = nlohmann::ordered_json;
using Matrix = std::array<double, 16>;

json rows_of(const Matrix& m, std::size_t rows) {
  json out = json::array();
  for (std::size_t r = 0; r < rows; ++r) out.push_back({m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]});
  return out;
}

Matrix inverse(const Matrix& m) {
  Matrix out{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k) {
      out[4 * r + k] = m[4 * k + r];
      out[4 * r + 3] -= m[4 * k + r] * m[4 * k + 3];
    }
  out[15] = 1;
  return out;
}

/// Spoils a matrix so that it is no camera's.
void spoil(Matrix& m, Draw& draw) {
  switch (draw.below(5)) {
    case 0:
      for (std::size_t i = 0; i < 12; ++i) m[i] = 0;
      break;
    case 1:
      for (const std::size_t r : {0u, 1u, 2u}) m[4 * r] = -m[4 * r];  // mirrored
      break;
    case 2:
      m[1] += 0.3;
      break;
    case 3:
      for (const std::size_t r : {0u, 1u, 2u})
        for (std::size_t k = 0; k < 3; ++k) m[4 * r + k] *= 2;
      break;
    default:
      m[3] = 1e13;
      break;
  }
}

enum class Times { unit, ticks, small, epoch, none, some, other_key };

/// How all frames of a case are written.
struct Style {
  Times times = Times::none;
  std::string time_key = "time";
  bool per_frame = false, angle = false, k_matrix = false, sizes = true, centre = true;
  std::string ending = "as is", before, prefix;
  bool backslashes = false;
  double last = 1;  ///< of the last row
  std::size_t rows = 4;
  std::string typo, typo_for;  ///< a field that is nearly named
};

Style draw_style(Case& c) {
  Draw& draw = c.draw;
  Style s;
  s.times = draw.one_of({Times::unit, Times::ticks, Times::small, Times::epoch, Times::none, Times::none,
                         Times::none, Times::none, Times::some, Times::other_key});
  if (s.times == Times::other_key)
    s.time_key = draw.one_of(
        {"Time", "times", "timestamp", "t", "frame_time", "time_stamp", "TIME", "timestep", "frame_id"});
  if (c.layout == "NeRFlow") {
    s.times = draw.one_of({Times::ticks, Times::unit, Times::none, Times::other_key});
    s.time_key = s.times == Times::other_key ? "time" : "timestep";
  }
  const bool same = std::all_of(c.shots.begin(), c.shots.end(),
                                [&](const Shot& x) { return x.seen.lens.fx == c.shots[0].seen.lens.fx; });
  s.per_frame = !same || draw.once_in(4);
  s.angle = same && !s.per_frame && c.shots[0].seen.lens.fx == c.shots[0].seen.lens.fy && draw.once_in(2);
  if (c.layout == "NeRFlow") {
    s.angle = true;
    for (Shot& x : c.shots) x.seen.lens = {};
  }
  s.k_matrix = !s.angle && draw.once_in(6);
  s.sizes = !draw.once_in(4);
  s.centre = s.sizes || !draw.once_in(3);
  s.prefix = draw.one_of({"images/", "images/", "", "rgb/", "./images/", "data/train/"});
  if (draw.once_in(12))
    s.before =
        draw.one_of({"C:\\Users\\me\\scene\\", "D:/x/scene/", "/home/me/scene/", ".\\", "/workspace/"});
  s.backslashes = s.before.find('\\') != std::string::npos || draw.once_in(25);
  s.ending = draw.one_of({"as is", "as is", "as is", "none"});
  s.rows = draw.once_in(8) ? 3 : 4;
  if (draw.once_in(25)) s.last = draw.one_of({0.00118, 0.5, 4.0});
  if (draw.once_in(12)) {
    const std::pair<const char*, const char*> typos[] = {{"f1_x", "fl_x"},
                                                         {"flx", "fl_x"},
                                                         {"f1_y", "fl_y"},
                                                         {"focal_x", "fl_x"},
                                                         {"c_x", "cx"},
                                                         {"Cy", "cy"},
                                                         {"camera_angel_x", "camera_angle_x"},
                                                         {"transform_matix", "transform_matrix"},
                                                         {"filepath", "file_path"},
                                                         {"file_name", "file_path"},
                                                         {"frame", "frames"},
                                                         {"image_width", "w"},
                                                         {"k_matrix", "K"},
                                                         {"pose", "transform_matrix"}};
    const auto& typo = typos[draw.below(std::size(typos))];
    s.typo = typo.first;
    s.typo_for = typo.second;
    c.broken = true;
    c.drawn.push_back("field " + s.typo);
  }
  constexpr const char* kTimes[] = {"0..1", "ticks", "small part", "epoch", "none", "some lack", "other key"};
  c.drawn.push_back(std::string("times ") + kTimes[int(s.times)] +
                    (s.times == Times::other_key ? " " + s.time_key : ""));
  return s;
}

void put_lens(json& object, const test::TrueLens& lens, const Style& s, const Case& c) {
  if (s.angle) {
    const double half = std::atan(0.5 * lens.wide / lens.fx);
    object["camera_angle_x"] = c.layout == "NeRFlow" ? 2 * half * 180 / 3.14159265358979323846 : 2 * half;
    return;
  }
  if (s.k_matrix) {
    object["K"] = {{lens.fx, 0, lens.cx}, {0, lens.fy, lens.cy}, {0, 0, 1}};
  } else {
    object["fl_x"] = lens.fx;
    object["fl_y"] = lens.fy;
    if (s.centre) {
      object["cx"] = lens.cx;
      object["cy"] = lens.cy;
    }
  }
  if (s.sizes) {
    object["w"] = lens.wide;
    object["h"] = lens.high;
  }
}

void put_time(json& frame, const Shot& shot, const Style& s, double last_tick, Draw& draw) {
  const double t = shot.time;
  switch (s.times) {
    case Times::unit:
      frame[s.time_key] = last_tick > 0 ? t / last_tick : 0;
      break;
    case Times::ticks:
    case Times::other_key:
      frame[s.time_key] = t;
      break;
    case Times::small:
      frame[s.time_key] = 0.02 + 0.004 * t;
      break;
    case Times::epoch:
      frame[s.time_key] = 1.7e9 + t / 30;
      break;
    case Times::some:
      if (!draw.once_in(4)) frame[s.time_key] = t;
      break;
    case Times::none:
      break;
  }
}

std::string listed(const std::string& path, const Style& s) {
  std::string text = path;
  if (s.ending == "none") text = text.substr(0, text.find_last_of('.'));
  text = s.before + text;
  if (s.backslashes) std::replace(text.begin(), text.end(), '/', '\\');
  return text;
}

void rename_field(json& object, const std::string& from, const std::string& to) {
  if (!object.is_object() || !object.contains(from)) return;
  const json value = object[from];
  object.erase(from);
  object[to] = value;
}

}  // namespace

std::vector<std::size_t> some_of(Draw& draw, std::size_t count, std::size_t n) {
  std::vector<std::size_t> all(n);
  for (std::size_t i = 0; i < n; ++i) all[i] = i;
  draw.shuffle(all);
  all.resize(std::min(count, n));
  return all;
}

void draw_splits(Case& c) {
  const std::size_t every = std::size_t(c.draw.between(3, 8));
  const bool by_camera = c.cameras > 2 && c.draw.once_in(2);
  for (Shot& s : c.shots) {
    const bool ends = !by_camera && (s.moment == 0 || s.moment + 1 == c.moments) && c.moments > 1;
    const bool test = by_camera ? s.camera == 1 : !ends && std::size_t(s.camera + s.moment) % every == 1;
    s.split = test ? "test" : "train";
  }
}

void write_transforms(Case& c) {
  Draw& draw = c.draw;
  const Style s = draw_style(c);
  if (s.times == Times::some || s.before.size() > 2) c.broken = true;
  if (draw.once_in(25) && c.turn != 1 && s.sizes && !s.angle) take_as_stored(c);
  const bool lists = c.layout == "nerfstudio" && draw.once_in(3);
  const bool files = c.layout != "nerfstudio" && !draw.once_in(4);
  if (lists || files) draw_splits(c);
  const bool other_pose =
      draw.once_in(15);  // OpenCV's axes, world to camera: nothing tells, they are as written
  double last_tick = 0;
  for (const Shot& shot : c.shots) last_tick = std::max(last_tick, shot.time);
  std::vector<std::size_t> order(c.shots.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  if (draw.once_in(2)) draw.shuffle(order);
  std::set<std::size_t> bad;
  if (draw.once_in(12)) {
    for (const std::size_t i : some_of(draw, std::size_t(draw.between(1, 3)), order.size())) bad.insert(i);
    c.broken = true;
    c.drawn.emplace_back("bad poses");
  }
  std::map<std::string, json> by_split;
  json names{{"train", json::array()}, {"test", json::array()}};
  const bool again = draw.once_in(25);  // frames that are there twice
  if (again) c.drawn.emplace_back("frames repeated");
  const bool misnamed = draw.once_in(25);
  if (misnamed) c.broken = true;
  const bool twice = lists && draw.once_in(6);  // pictures that two lists name
  for (const std::size_t i : order) {
    Shot& shot = c.shots[i];
    const std::string folder = shot.split == "test" && s.prefix == "data/train/" ? "data/test/" : s.prefix;
    shot.path = folder + shot.path;
    place_picture(c, i);
    json frame{{"file_path", listed(shot.path, s)}};
    Matrix m = shot.seen.to_world;
    if (other_pose) {
      m = inverse(m);
      if (c.layout != "NeRFlow") shot.seen.to_world = m;
    }
    if (c.layout == "NeRFlow") {
      if (other_pose) shot.seen.to_world = m;
      m = inverse(shot.seen.to_world);
    }
    if (bad.count(i)) {
      spoil(m, draw);
      shot.there = false;
    }
    m[15] = s.last;
    if (s.rows == 4 && s.last == 4.0)
      for (std::size_t k = 0; k < 12; ++k) m[k] *= 4;
    frame["transform_matrix"] = rows_of(m, s.rows);
    put_time(frame, shot, s, last_tick, draw);
    if (s.per_frame) put_lens(frame, shot.seen.lens, s, c);
    if (!s.typo.empty()) rename_field(frame, s.typo_for, s.typo);
    by_split[files ? shot.split : "train"].push_back(frame);
    if (again && draw.once_in(4)) by_split[draw.once_in(2) || !files ? "train" : "test"].push_back(frame);
    names[shot.split.empty() ? "train" : shot.split].push_back(listed(shot.path, s));
    if (twice && shot.split == "test") names["train"].push_back(listed(shot.path, s));
  }
  if (twice) c.drawn.emplace_back("lists overlap");
  for (auto& [split, frames] : by_split) {
    json file = json::object();
    if (!s.per_frame) put_lens(file, c.shots[0].seen.lens, s, c);
    if (draw.once_in(4)) file["applied_transform"] = {{0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, -1, 0}};
    if (!s.typo.empty()) rename_field(file, s.typo_for, s.typo);
    file["frames"] = frames;
    if (s.typo_for == "frames") rename_field(file, "frames", s.typo);
    if (lists)
      for (const auto& [name, list] : names.items())
        if (!list.empty()) file[name + "_filenames"] = list;
    std::string name = c.layout == "nerfstudio" ? "transforms.json"
                       : c.layout == "NeRFlow"  ? "transform_" + split + ".json"
                                                : "transforms_" + split + ".json";
    if (misnamed) {
      const std::size_t kind = std::size_t(c.shots.size() % 3);
      if (kind == 0) name.erase(name.find("transforms") == 0 ? 9 : 8, 1);  // in the singular, or transfor_
      if (kind == 1) name = name.substr(0, name.size() - 4) + "JSON";
      if (kind == 2) std::replace(name.begin(), name.end(), '_', '-');
      c.drawn.push_back("file " + name);
    }
    test::write_text(std::filesystem::path(c.folder) / name, file.dump(1));
  }
  if (s.times == Times::none || s.times == Times::other_key) draw_times_file(c);
}

}  // namespace splinevox::torture::structure
