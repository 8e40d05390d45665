// SPDX-License-Identifier: Apache-2.0
#include "view/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "run/html.hpp"
#include "view/codec.hpp"

namespace splinevox::run {
namespace {

constexpr const char* kShaders[] = {"pass.vert",   "contract.frag", "occupancy.frag",
                                    "blocks.frag", "march.frag",    "present.frag"};
constexpr const char* kScripts[] = {"basis.js",  "data.js",    "layers.js", "gl.js",       "scene.js",
                                    "camera.js", "painter.js", "state.js",  "controls.js", "main.js"};

Json camera_json(const Camera& c) {
  Json axes = Json::array();
  for (const Vec3d& a : c.axes) axes.push_back(triple(a));
  return {{"width", c.width}, {"height", c.height}, {"fx", c.fx},   {"fy", c.fy},
          {"cx", c.cx},       {"cy", c.cy},         {"axes", axes}, {"position", triple(c.position)}};
}

Json taken_json(const TakenFrom& taken) {
  Json directions = Json::array();
  for (const Vec3d& d : taken.directions) directions.push_back(triple(d));
  return {{"middle", triple(taken.middle)},
          {"directions", directions},
          {"near", taken.near},
          {"far", taken.far},
          {"spacing", taken.spacing}};
}

/// JSON that may stand inside a script element: no byte of it can end one.
std::string embedded(const Json& json) {
  std::string out;
  for (const char c : json_text(json)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

std::string poster_element(const std::vector<char>& png) {
  if (png.empty()) return "";
  return fmt::format("<img id=\"poster\" alt=\"the scene\" src=\"data:image/png;base64,{}\">", base64(png));
}

struct Mark {
  std::string_view name;
  std::string text;
};

/// The page with texts in place of its marks. A text is not looked through for marks: it may hold anything.
std::string filled(std::string_view page, const std::vector<Mark>& marks) {
  std::string out;
  for (;;) {
    const Mark* next = nullptr;
    std::size_t at = page.size();
    for (const Mark& mark : marks)
      if (const std::size_t found = page.find(mark.name); found < at) {
        next = &mark;
        at = found;
      }
    out += page.substr(0, at);
    if (!next) return out;
    out += next->text;
    page.remove_prefix(at + next->name.size());
  }
}

}  // namespace

Json view_header(const ViewPage& page, const PackedScene& scene) {
  Json header = scene.header;
  header["name"] = page.name;
  header["note"] = page.note;
  header["full_flow"] = page.full_flow;
  header["views"] = Json::array();
  for (const TrueShot& s : page.shots)
    header["views"].push_back({{"name", s.name},
                               {"time", s.time},
                               {"camera", camera_json(s.camera)},
                               {"picture", "data:image/png;base64," + base64(s.png)}});
  header["split"] = page.split;
  header["clear"] =
      std::any_of(page.shots.begin(), page.shots.end(), [](const TrueShot& s) { return s.clear; });
  if (page.taken) header["taken"] = taken_json(*page.taken);
  if (page.start)
    header["start"] = {{"view", page.start->view},
                       {"time", page.start->shot.time},
                       {"camera", camera_json(page.start->shot.camera)}};
  return header;
}

std::vector<TrueShot> page_shots(const Split& split, const VoxelModel& model, int count, int size) {
  const bool learned = model.background.count() > 0 || model.surroundings.any();
  return true_shots(split, learned ? std::optional(model.background.color) : std::nullopt, count, size);
}

std::string viewer_page(const ViewerParts& parts) {
  std::string shaders, scripts;
  for (const char* name : kShaders)
    shaders += fmt::format("<script type=\"x-shader\" id=\"{}\">{}</script>\n", name, view_asset(name));
  for (const char* name : kScripts) scripts += view_asset(name);
  return filled(view_asset("page.html"), {{"<!--title-->", escape(parts.title)},
                                          {"<!--model-->", escape(parts.model)},
                                          {"<!--heading-->", escape(parts.title)},
                                          {"<!--about-->", escape(parts.about)},
                                          {"/*style*/", std::string(view_asset("style.css")) + parts.style},
                                          {"/*class*/", parts.body_class},
                                          {"<!--poster-->", poster_element(parts.poster)},
                                          {"<!--beside-->", parts.beside},
                                          {"<!--shaders-->", shaders},
                                          {"<!--data-->", parts.data},
                                          {"/*scripts*/", scripts + parts.scripts}});
}

std::string view_page(const ViewPage& page, const PackedScene& scene) {
  return viewer_page({.title = page.name,
                      .about = page.about,
                      .model = page.model,
                      .poster = page.start ? page.start->poster : std::vector<char>{},
                      .data = "<script type=\"application/json\" id=\"header\">" +
                              embedded(view_header(page, scene)) +
                              "</script>\n<script type=\"text/plain\" id=\"data\">" +
                              base64(deflated(scene.bytes)) + "</script>",
                      .scripts = std::string(view_asset("start.js"))});
}

}  // namespace splinevox::run
