// SPDX-License-Identifier: Apache-2.0
#include "cli/dataset_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "data/message_text.hpp"
#include "math/camera.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::cli {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kForward =
    0.8;  // length of the mean viewing direction: cameras within about 50 degrees of each other

/// How far the distortion moves the picture's border at most, pixels.
double largest_shift(const Camera& c) {
  double worst = 0;
  for (int i = 0; i <= 16; ++i)
    for (const auto& [u, v] : {std::pair{c.width * i / 16.0, 0.0},
                               {c.width * i / 16.0, double(c.height)},
                               {0.0, c.height * i / 16.0},
                               {double(c.width), c.height * i / 16.0}}) {
      const Vec3d d = camera_ray(c, u, v).direction;
      const double depth = -dot(d, c.axes[2]);
      if (depth > 1e-3)
        worst = std::max(worst, std::hypot(c.cx + c.fx * dot(d, c.axes[0]) / depth - u,
                                           c.cy - c.fy * dot(d, c.axes[1]) / depth - v));
    }
  return worst;
}

/// Between the rays through the lens's centre and through a place in the picture, radians.
double angle(const Camera& c, const std::array<double, 2>& place) {
  const Vec3d a = camera_ray(c, c.cx, c.cy).direction, b = camera_ray(c, place[0], place[1]).direction;
  return std::atan2(length(cross(a, b)), dot(a, b));
}

Json lens_json(const Camera& c) {
  Json j{{"fl_x", c.fx},
         {"fl_y", c.fy},
         {"cx", c.cx},
         {"cy", c.cy},
         {"field_of_view",
          {kDegrees * (angle(c, {0, c.cy}) + angle(c, {double(c.width), c.cy})),
           kDegrees * (angle(c, {c.cx, 0}) + angle(c, {c.cx, double(c.height)}))}}};
  if (c.lens.kind == Distortion::Kind::none) return j;
  j["distortion"] = {{"model", c.lens.kind == Distortion::Kind::fisheye ? "fisheye" : "brown"},
                     {"k", c.lens.k},
                     {"p", c.lens.p},
                     {"largest_shift", largest_shift(c)}};
  return j;
}

/// Lenses, places and directions of all cameras.
Json cameras_json(const Dataset& data) {
  std::set<std::vector<double>> lenses, places;
  Vec3d sum{}, lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  std::size_t count = 0;
  for (const Split& s : data.splits)
    for (const Frame& f : s.frames) {
      const Camera& c = f.camera;
      lenses.insert({c.fx, c.fy, c.cx, c.cy, c.lens.k[0], c.lens.k[1], c.lens.k[2], c.lens.k[3], c.lens.p[0],
                     c.lens.p[1], double(c.lens.kind)});
      places.insert({c.position.x, c.position.y, c.position.z, c.axes[2].x, c.axes[2].y, c.axes[2].z});
      sum -= c.axes[2];
      ++count;
      lo = min(lo, c.position);
      hi = max(hi, c.position);
    }
  const double together = length(sum) / double(std::max<std::size_t>(count, 1));
  Json j{{"places", places.size()},
         {"lenses", lenses.size()},
         {"lens", lens_json(data.splits[0].frames[0].camera)}};
  j["positions"] = {{lo.x, lo.y, lo.z}, {hi.x, hi.y, hi.z}};
  j["forward_facing"] = together > kForward;
  Json rig = Json::array();
  for (const RigCamera& camera : data.cameras)
    rig.push_back({{"name", camera.name}, {"still", camera.still}});
  if (!rig.empty()) j["rig"] = rig;
  return j;
}

std::string text_of(const Json& corner) {
  return fmt::format("[{:.4g} {:.4g} {:.4g}]", corner[0].get<double>(), corner[1].get<double>(),
                     corner[2].get<double>());
}

}  // namespace

Json dataset_json(const std::string& path, const DatasetRules& rules, bool pixels) {
  const Dataset data =
      load_dataset(path, {.rules = rules, .pixels = pixels, .depth = true, .tracks = true, .keep = false});
  Json splits = Json::array();
  for (const Split& s : data.splits) {
    std::set<double> times;
    for (const Frame& f : s.frames) times.insert(f.time);
    const Frame& first = s.frames.front();
    splits.push_back({{"name", s.name},
                      {"frames", s.frames.size()},
                      {"width", first.camera.width},
                      {"height", first.camera.height},
                      {"times", {*times.begin(), *times.rbegin()}},
                      {"moments", times.size()}});
  }
  Json j{{"dataset", data.path},
         {"format", data.format},
         {"alpha", data.has_alpha},
         {"pictures_read", pixels},
         {"time_map", {{"origin", data.time_map.origin}, {"scale", data.time_map.scale}}},
         {"splits", splits},
         {"cameras", cameras_json(data)},
         {"notes", data.notes}};
  if (data.masks)
    j["masks"] = {{"use", data.masks->use},
                  {"pictures", data.masks->pictures},
                  {"frames", data.masks->frames},
                  {"example", data.masks->example},
                  {"looked_at", data.masks->looked_at},
                  {"white", data.masks->white}};
  if (data.tracks)
    j["tracks"] = {{"file", data.tracks->file},
                   {"points", data.tracks->points},
                   {"pictures", data.tracks->pictures},
                   {"visible", data.tracks->visible}};
  if (data.depth)
    j["depth"] = {{"kind", data.depth->kind},           {"pictures", data.depth->pictures},
                  {"frames", data.depth->frames},       {"example", data.depth->example},
                  {"looked_at", data.depth->looked_at}, {"known", data.depth->known}};
  if (pixels) j["fingerprint"] = fmt::format("{:016x}", data.fingerprint);
  if (data.box)
    j["box"] = {{data.box->lo.x, data.box->lo.y, data.box->lo.z},
                {data.box->hi.x, data.box->hi.y, data.box->hi.z}};
  return j;
}

void print_dataset(const Json& j) {
  const bool alpha = j["alpha"].get<bool>();
  fmt::print("{}: {}, {}\n", j["dataset"].get<std::string>(), j["format"].get<std::string>(),
             alpha ? "pictures with alpha" : "opaque pictures");
  for (const Json& s : j["splits"])
    fmt::print("  {:<6} {:>5} frames of {}x{}, model times {:.4f} to {:.4f}, {} moments\n",
               s["name"].get<std::string>(), s["frames"].get<int>(), s["width"].get<int>(),
               s["height"].get<int>(), s["times"][0].get<double>(), s["times"][1].get<double>(),
               s["moments"].get<int>());
  const Json& map = j["time_map"];
  if (map["scale"].get<double>() != 0 &&
      (map["scale"].get<double>() != 1 || map["origin"].get<double>() != 0))
    fmt::print("  times  {} to {} in the data\n", data::time_text(map["origin"].get<double>()),
               data::time_text(map["origin"].get<double>() + 1 / map["scale"].get<double>()));
  const Json &c = j["cameras"], &lens = c["lens"];
  fmt::print(
      "  lens   focal length {:.6g} x {:.6g} pixels ({:.0f} x {:.0f} degrees), centre {:.6g}, {:.6g}{}\n",
      lens["fl_x"].get<double>(), lens["fl_y"].get<double>(), lens["field_of_view"][0].get<double>(),
      lens["field_of_view"][1].get<double>(), lens["cx"].get<double>(), lens["cy"].get<double>(),
      c["lenses"].get<int>() > 1 ? fmt::format("; the first of {} lenses", c["lenses"].get<int>()) : "");
  if (lens.contains("distortion"))
    fmt::print("         {} distortion, up to {:.1f} pixels; rays follow it, pictures stay as they are\n",
               lens["distortion"]["model"].get<std::string>(),
               lens["distortion"]["largest_shift"].get<double>());
  fmt::print("  places {} cameras from {} to {}{}\n", c["places"].get<int>(), text_of(c["positions"][0]),
             text_of(c["positions"][1]),
             c["forward_facing"].get<bool>() ? ", all looking much the same way" : "");
  if (c.contains("rig")) {
    const auto still = std::count_if(c["rig"].begin(), c["rig"].end(),
                                     [](const Json& camera) { return camera["still"].get<bool>(); });
    fmt::print("  rig    {} cameras film, {} of them stand still, such as {}\n", c["rig"].size(), still,
               c["rig"][0]["name"].get<std::string>());
  }
  if (j.contains("masks"))
    fmt::print(
        "  masks  of {} of {} pictures, {}{}\n", j["masks"]["pictures"].get<int>(),
        j["masks"]["frames"].get<int>(),
        j["masks"]["use"].get<std::string>().empty() ? "not used" : j["masks"]["use"].get<std::string>(),
        j["masks"]["looked_at"].get<int>() > 0
            ? fmt::format("; white on average {:.1f}%", 100 * j["masks"]["white"].get<double>())
            : "");
  if (j.contains("tracks"))
    fmt::print("  tracks of {} points through {} pictures; {:.1f}% visible\n",
               j["tracks"]["points"].get<int>(), j["tracks"]["pictures"].get<int>(),
               100 * j["tracks"]["visible"].get<double>());
  if (j.contains("depth"))
    fmt::print("  depth  of {} of {} training pictures, {}{}\n", j["depth"]["pictures"].get<int>(),
               j["depth"]["frames"].get<int>(),
               j["depth"]["kind"] == "none" ? "not used" : j["depth"]["kind"].get<std::string>(),
               j["depth"]["looked_at"].get<int>() > 0
                   ? fmt::format("; known in {:.1f}% of the pixels", 100 * j["depth"]["known"].get<double>())
                   : "");
  if (j.contains("box"))
    fmt::print("  box    {} to {}{}\n", text_of(j["box"][0]), text_of(j["box"][1]),
               alpha ? ", not used: silhouettes say more" : "");
  for (const Json& note : j["notes"]) fmt::print("  note: {}\n", note.get<std::string>());
}

}  // namespace splinevox::cli
