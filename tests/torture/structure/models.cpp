// SPDX-License-Identifier: Apache-2.0
// Layouts of other programs: COLMAP, LLFF, NR-NeRF, Nerfies, DyNeRF.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "data/times/names.hpp"
#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;
using test::append, test::exactly;

/// The shots by their lens: COLMAP's cameras.
std::map<double, int> lenses_of(const Case& c) {
  std::map<double, int> of;
  for (const Shot& s : c.shots) of.try_emplace(s.seen.lens.fx, int(of.size()) + 1);
  return of;
}

std::string lens_line(const test::TrueLens& l, int id) {
  return std::to_string(id) + " PINHOLE " + std::to_string(l.wide) + " " + std::to_string(l.high) + " " +
         exactly(l.fx) + " " + exactly(l.fy) + " " + exactly(l.cx) + " " + exactly(l.cy) + "\n";
}

/// One sparse model of some shots.
void write_text_model(Case& c, const fs::path& place, const std::vector<std::size_t>& shots) {
  const std::map<double, int> lenses = lenses_of(c);
  std::string cameras = "# Camera list with one line of data per camera:\n", images = "# Image list\n";
  for (const auto& [fx, id] : lenses)
    for (const Shot& s : c.shots)
      if (s.seen.lens.fx == fx) {
        cameras += lens_line(s.seen.lens, id);
        break;
      }
  const std::size_t points = c.draw.below(4);
  for (const std::size_t i : shots) {
    const Shot& s = c.shots[i];
    images += std::to_string(i + 1);
    for (const double v : test::quaternion_of(s.seen)) images.append(" ").append(exactly(v));
    for (const double v : test::translation_of(s.seen)) images.append(" ").append(exactly(v));
    images.append(" ")
        .append(std::to_string(lenses.at(s.seen.lens.fx)))
        .append(" ")
        .append(s.path)
        .append("\n");
    if (points == 0)
      images += "\n";
    else if (points == 1)
      images += "1.5 2.5 -1 3 4 7\n";
    else if (points == 2)
      images += i % 2 ? "10 20 3\n" : "\n";
  }
  test::write_text(fs::path(c.folder) / place / "cameras.txt", cameras);
  test::write_text(fs::path(c.folder) / place / "images.txt", images);
}

void write_binary_model(Case& c, const fs::path& place, const std::vector<std::size_t>& shots) {
  const std::map<double, int> lenses = lenses_of(c);
  test::Bytes cameras, images;
  append(cameras, std::uint64_t(lenses.size()));
  for (const auto& [fx, id] : lenses) {
    const auto shot = std::find_if(c.shots.begin(), c.shots.end(),
                                   [&, f = fx](const Shot& s) { return s.seen.lens.fx == f; });
    const test::TrueLens& l = shot->seen.lens;
    append(cameras, std::uint32_t(id));
    append(cameras, std::int32_t(1));
    append(cameras, std::uint64_t(l.wide));
    append(cameras, std::uint64_t(l.high));
    for (const double v : {l.fx, l.fy, l.cx, l.cy}) append(cameras, v);
  }
  append(images, std::uint64_t(shots.size()));
  for (const std::size_t i : shots) {
    const Shot& s = c.shots[i];
    append(images, std::uint32_t(i + 1));
    for (const double v : test::quaternion_of(s.seen)) append(images, v);
    for (const double v : test::translation_of(s.seen)) append(images, v);
    append(images, std::uint32_t(lenses.at(s.seen.lens.fx)));
    images.insert(images.end(), s.path.begin(), s.path.end());
    images.push_back(0);
    append(images, std::uint64_t(0));
  }
  test::write_bytes(fs::path(c.folder) / place / "cameras.bin", cameras);
  test::write_bytes(fs::path(c.folder) / place / "images.bin", images);
}

/// The numbers of shots in an order of their paths.
template <class Less>
std::vector<std::size_t> by_path(const Case& c, const Less& less) {
  std::vector<std::size_t> order(c.shots.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return less(c.shots[a].path, c.shots[b].path); });
  return order;
}

}  // namespace

void take_as_stored(Case& c) {
  c.as_stored = true;
  if (c.turn < 5) return;
  for (Shot& s : c.shots) {
    std::swap(s.seen.lens.wide, s.seen.lens.high);
    std::swap(s.seen.lens.cx, s.seen.lens.cy);
  }
}

void draw_times_file(Case& c) {
  Draw& draw = c.draw;
  if (!draw.once_in(6)) return;
  c.drawn.emplace_back("times.txt");
  const std::size_t kind = draw.below(3);
  const double unit = draw.one_of({1.0, 0.001, 1 / 30.0});
  std::string text = draw.once_in(2) ? "# name time\n" : "";
  for (const std::size_t i : some_of(draw, c.shots.size(), c.shots.size())) {
    const fs::path path = c.shots[i].path;
    const std::string name = kind == 0   ? path.string()
                             : kind == 1 ? path.filename().string()
                                         : path.stem().string();
    text += name + (draw.once_in(20) ? ", " : " ") + exactly(unit * c.shots[i].time) + "\n";
  }
  if (draw.once_in(8)) {
    text = text.substr(0, text.find_last_of('\n', text.size() - 2) + 1);  // the last line is missing
    c.broken = true;
  }
  if (kind > 0) c.broken = true;  // names may be there twice, in two folders
  test::write_text(fs::path(c.folder) / "times.txt", text);
}

void write_colmap(Case& c) {
  Draw& draw = c.draw;
  if (c.turn != 1) take_as_stored(c);
  const std::string place =
      draw.one_of({"sparse/0", "sparse/0", "sparse", "colmap/sparse/0", "colmap_sparse/0", "."});
  const std::string pictures = draw.one_of({"images/", "images/", "input/", "rgb/"});
  std::vector<std::size_t> order = some_of(draw, c.shots.size(), c.shots.size()), second;
  if (draw.once_in(12) && order.size() > 6 && place.ends_with("0")) {
    const auto half = order.begin() + std::ptrdiff_t(order.size() / 3);
    second.assign(order.begin(), half);
    order.erase(order.begin(), half);
    if (draw.once_in(2)) std::swap(order, second);
    c.drawn.emplace_back("two models");
  } else if (draw.once_in(12) && order.size() > 4) {
    order.resize(order.size() - std::size_t(draw.between(1, 3)));
    c.drawn.emplace_back("pictures without cameras");
  }
  const auto write = [&](const fs::path& inside, const std::vector<std::size_t>& shots) {
    c.layout == "COLMAP text" ? write_text_model(c, inside, shots) : write_binary_model(c, inside, shots);
  };
  write(place, order);
  if (!second.empty()) write(place.substr(0, place.size() - 1) + "1", second);
  for (std::size_t i = 0; i < c.shots.size(); ++i) {
    c.shots[i].path = pictures + c.shots[i].path;
    c.shots[i].there = std::find(order.begin(), order.end(), i) != order.end();
    place_picture(c, i);
  }
  draw_times_file(c);
}

void write_rows(Case& c) {
  Draw& draw = c.draw;
  if (c.turn != 1) take_as_stored(c);
  const bool llff = c.layout == "LLFF";
  const std::string pictures = draw.one_of({"images/", "images/", "images_4/"});
  const bool counted = draw.once_in(3);  // rows in the order in which people count
  if (counted) c.drawn.emplace_back("rows as people count");
  const double scale = pictures == "images_4/" ? 4 : 1;
  const std::vector<std::size_t> order =
      counted ? by_path(c, [](const auto& a, const auto& b) { return data::natural_less(a, b); })
              : by_path(c, std::less<>());
  std::vector<double> rows;
  json poses = json::array(), bounds = json::array();
  for (const std::size_t i : order) {
    test::TrueCamera& seen = c.shots[i].seen;
    seen.lens.fy = seen.lens.fx;  // all that a row says
    const double hwf[] = {scale * seen.lens.high, scale * seen.lens.wide, scale * seen.lens.fx};
    json pose = json::array();
    for (int r = 0; r < 3; ++r) {
      const double across = seen.world(r, 0), up = seen.world(r, 1), back = seen.world(r, 2),
                   at = seen.world(r, 3);
      for (const double v : {-up, across, back, at, hwf[r]}) rows.push_back(v);
      pose.push_back({across, up, back, at, hwf[r]});
    }
    rows.push_back(1.5);
    rows.push_back(5);
    poses.push_back(pose);
    bounds.push_back({1.5, 5});
  }
  if (llff)
    test::write_bytes(fs::path(c.folder) / "poses_bounds.npy", test::npy_bytes(order.size(), 17, rows));
  else
    test::write_text(fs::path(c.folder) / "precomputed.json", json{{"poses", poses}, {"bds", bounds}}.dump());
  for (std::size_t i = 0; i < c.shots.size(); ++i) {
    c.shots[i].path = pictures + c.shots[i].path;
    place_picture(c, i);
  }
  draw_times_file(c);
}

void write_nerfies(Case& c) {
  Draw& draw = c.draw;
  if (c.turn != 1) take_as_stored(c);
  const double shrink = draw.one_of({1.0, 2.0, 4.0});
  const std::string pictures = "rgb/" + std::to_string(int(shrink)) + "x/";
  const std::string key = draw.one_of({"time_id", "warp_id", "both", "appearance_id"});
  if (!draw.once_in(3)) draw_splits(c);
  c.drawn.push_back("times " + key);
  if (key == "appearance_id") c.broken = true;
  json train = json::array(), val = json::array(), meta = json::object();
  for (const std::size_t i : some_of(draw, c.shots.size(), c.shots.size())) {
    Shot& s = c.shots[i];
    const std::string id = s.path.substr(0, s.path.find_last_of('.'));
    (s.split == "test" ? val : train).push_back(id);
    if (key == "both")
      meta[id] = {{"time_id", int(s.time)}, {"warp_id", s.moment}};
    else
      meta[id] = {{key, int(s.time)}, {"camera_id", s.camera}};
    json orientation = json::array(), position = json::array();
    for (int r = 0; r < 3; ++r) {
      const double sign = r == 0 ? 1 : -1;
      orientation.push_back(
          {sign * s.seen.world(0, r), sign * s.seen.world(1, r), sign * s.seen.world(2, r)});
      position.push_back(s.seen.world(r, 3));
    }
    const test::TrueLens& l = s.seen.lens;
    const json camera{{"orientation", orientation},
                      {"position", position},
                      {"focal_length", shrink * l.fx},
                      {"pixel_aspect_ratio", l.fy / l.fx},
                      {"principal_point", {shrink * l.cx, shrink * l.cy}},
                      {"skew", 0.0},
                      {"image_size", {int(shrink) * l.wide, int(shrink) * l.high}}};
    test::write_text(fs::path(c.folder) / "camera" / (id + ".json"), camera.dump());
    s.path = pictures + s.path;
    place_picture(c, i);
  }
  test::write_text(fs::path(c.folder) / "dataset.json", json{{"train_ids", train}, {"val_ids", val}}.dump());
  test::write_text(fs::path(c.folder) / "metadata.json", meta.dump());
  if (draw.once_in(2))
    test::write_text(fs::path(c.folder) / "scene.json",
                     R"({"scale": 1.0, "center": [0, 0, 0], "near": 1, "far": 5})");
}

void write_rig(Case& c) {
  Draw& draw = c.draw;
  const bool films = c.layout.ends_with("films");
  if (c.turn != 1) take_as_stored(c);
  std::vector<std::pair<std::string, std::size_t>> cameras;  // folder or film, a shot of it
  for (std::size_t i = 0; i < c.shots.size(); ++i)
    if (c.shots[i].moment == 0) cameras.emplace_back(c.shots[i].path.substr(0, c.shots[i].path.find('/')), i);
  const bool counted = draw.once_in(2);
  std::sort(cameras.begin(), cameras.end(), [&](const auto& a, const auto& b) {
    return counted ? data::natural_less(a.first, b.first) : a.first < b.first;
  });
  std::vector<double> rows;
  for (const auto& [name, shot] : cameras) {
    const test::TrueCamera& seen = c.shots[shot].seen;
    const double hwf[] = {double(seen.lens.high), double(seen.lens.wide), seen.lens.fx};
    for (int r = 0; r < 3; ++r)
      for (const double v : {-seen.world(r, 1), seen.world(r, 0), seen.world(r, 2), seen.world(r, 3), hwf[r]})
        rows.push_back(v);
    rows.push_back(1.5);
    rows.push_back(5);
  }
  for (Shot& s : c.shots) s.seen.lens.fy = s.seen.lens.fx;
  test::write_bytes(fs::path(c.folder) / "poses_bounds.npy", test::npy_bytes(cameras.size(), 17, rows));
  if (!films) {
    for (std::size_t i = 0; i < c.shots.size(); ++i) place_picture(c, i);
    draw_times_file(c);
    return;
  }
  for (const auto& [name, shot] : cameras) {
    const int every = c.moments > 4 && draw.once_in(4) ? 2 : 1;  // a film of half the rate
    for (Shot& s : c.shots)
      if (s.camera == c.shots[shot].camera) {
        s.time = s.moment;
        s.there = s.moment % every == 0;
      }
    place_film(c, c.shots[shot].camera, name, every);
  }
}

}  // namespace splinevox::torture::structure
