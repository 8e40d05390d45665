// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <utility>

#include "data/synth/scene.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace data {

Shape make_ball(double radius) {
  Shape s;
  s.r0 = s.r1 = radius;
  return s;
}

Shape make_cone(double r0, double r1, double height, const Vec3d& flat) {
  Shape s;
  s.kind = Shape::Kind::cone;
  s.r0 = r0;
  s.r1 = r1;
  s.height = height;
  s.flat = flat;
  return s;
}

Shape make_box(const Vec3d& half, double round) {
  Shape s;
  s.kind = Shape::Kind::box;
  s.half = half;
  s.round = round;
  return s;
}

Shape make_disc(double radius, double half_height, double round) {
  Shape s;
  s.kind = Shape::Kind::disc;
  s.r0 = s.r1 = radius;
  s.height = half_height;
  s.round = round;
  return s;
}

Shape make_room(const Vec3d& half) {
  Shape s;
  s.kind = Shape::Kind::room;
  s.half = half;
  return s;
}

Shape make_tube(double length, std::function<double(double)> radius, double widest, double slope) {
  Shape s;
  s.kind = Shape::Kind::tube;
  s.height = length;
  s.radius = std::move(radius);
  s.widest = widest;
  s.slope = slope;
  return s;
}

std::function<Pose(double)> still(const Place& place) {
  return [place](double) { return Pose{place, {1, 1, 1}, {}}; };
}

namespace {

struct Entry {
  const char* name;
  std::vector<void (*)(Bodies&)> parts;
  std::size_t frozen;  ///< how many of them, from the first, stay as they are at time 0
  const Gas* gas = nullptr;
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list{{"dancer", {add_stage, add_plant, add_figure, add_bouncing_ball}, 0},
                                       {"ball", {add_sliding_ball}, 0},
                                       {"snake", {add_snake}, 0},
                                       {"toy", {add_stage, add_plant, add_figure, add_bouncing_ball}, 3},
                                       {"garden", {add_stage, add_figure, add_plant, add_bouncing_ball}, 2},
                                       {"static", {add_stage, add_plant, add_figure, add_bouncing_ball}, 4},
                                       {"smoke", {}, 0, &kSmoke},
                                       {"fire", {}, 0, &kFire},
                                       {"enters", {add_stage, add_plant, add_figure, add_entering_ball}, 3},
                                       {"leaves", {add_stage, add_plant, add_figure, add_leaving_ball}, 3}};
  return list;
}

/// Letters to insert, delete or replace to get from one word to the other.
int edits(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = std::exchange(row[0], int(i));
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({replaced, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return row.back();
}

}  // namespace
}  // namespace data

std::vector<std::string> synth_scenes() {
  std::vector<std::string> names;
  for (const data::Entry& entry : data::entries()) names.push_back(entry.name);
  return names;
}

SynthScene SynthScene::open(const std::string& name, const SynthLook& look) {
  for (const data::Entry& entry : data::entries()) {
    if (entry.name != name) continue;
    auto content = std::make_shared<Content>();
    for (std::size_t part = 0; part < entry.parts.size(); ++part) {
      const std::size_t before = content->bodies.size();
      entry.parts[part](content->bodies);
      for (std::size_t b = before; part < entry.frozen && b < content->bodies.size(); ++b)
        content->bodies[b].pose = [pose = content->bodies[b].pose(0)](double) { return pose; };
    }
    content->gas = entry.gas;
    content->subjects = int(content->bodies.size());
    if (look.room) data::add_room(content->bodies);
    for (const data::Body& body : content->bodies) content->rest.push_back(body.pose(0));
    content->look = look;
    return SynthScene(std::move(content));
  }
  const std::vector<std::string> names = synth_scenes();
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
  const auto nearest = std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
    return data::edits(name, a) < data::edits(name, b);
  });
  fail({.where = "synth",
        .what = "there is no built-in scene of that name",
        .expected = all,
        .got = "'" + name + "'",
        .hint = "splinevox synth " + *nearest});
}

}  // namespace splinevox
