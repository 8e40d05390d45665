// SPDX-License-Identifier: Apache-2.0
// The camera models of COLMAP up to 4.2, by the order of their parameters.
#include <cmath>
#include <sstream>

#include "data/layouts/colmap_model.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

/// `parameters`: what each number is. "0": the lens is ours if this one is zero. "any": it then has no
/// effect.
constexpr ColmapKind kKinds[] = {
    {"SIMPLE_PINHOLE", 0, false, "f cx cy"},
    {"PINHOLE", 1, false, "fx fy cx cy"},
    {"SIMPLE_RADIAL", 2, false, "f cx cy k1"},
    {"RADIAL", 3, false, "f cx cy k1 k2"},
    {"OPENCV", 4, false, "fx fy cx cy k1 k2 p1 p2"},
    {"OPENCV_FISHEYE", 5, true, "fx fy cx cy k1 k2 k3 k4"},
    {"FULL_OPENCV", 6, false, "fx fy cx cy k1 k2 p1 p2 k3 0 0 0"},
    {"FOV", 7, false, "fx fy cx cy 0"},
    {"SIMPLE_RADIAL_FISHEYE", 8, true, "f cx cy k1"},
    {"RADIAL_FISHEYE", 9, true, "f cx cy k1 k2"},
    {"THIN_PRISM_FISHEYE", 10, true, "fx fy cx cy k1 k2 0 0 k3 k4 0 0"},
    {"RAD_TAN_THIN_PRISM_FISHEYE", 11, true, "fx fy cx cy k1 k2 k3 k4 0 0 0 0 0 0 0 0"},
    {"SIMPLE_DIVISION", 12, false, "f cx cy 0"},
    {"DIVISION", 13, false, "fx fy cx cy 0"},
    {"SIMPLE_FISHEYE", 14, true, "f cx cy"},
    {"FISHEYE", 15, true, "fx fy cx cy"},
    {"EUCM", 16, false, "fx fy cx cy 0 any"},
    {"EQUIRECTANGULAR", 17, false, "w h"}};

std::vector<std::string> words_of(const char* text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// Where a parameter of this name goes; null if it has no place in our lenses.
std::optional<double>* place_of(const std::string& name, Lens& lens) {
  const std::pair<const char*, std::optional<double>*> places[] = {
      {"f", &lens.fl_x}, {"fx", &lens.fl_x}, {"fy", &lens.fl_y}, {"cx", &lens.cx},
      {"cy", &lens.cy},  {"k1", &lens.k1},   {"k2", &lens.k2},   {"k3", &lens.k3},
      {"k4", &lens.k4},  {"p1", &lens.p1},   {"p2", &lens.p2}};
  for (const auto& [known, place] : places)
    if (name == known) return place;
  return nullptr;
}

[[noreturn]] void fail_lens(const ColmapKind& kind, const std::string& got, const std::string& where) {
  const bool round = kind.id == 17;
  fail({where, std::string("the camera model ") + kind.name + " is not supported",
        "PINHOLE, RADIAL, OPENCV, a fisheye of these, or a model whose further parameters are 0", got,
        round
            ? "a picture of all directions is no camera's: cut it into PINHOLE views with poses of their own "
              "(COLMAP's panorama_sfm.py)"
            : "colmap image_undistorter makes PINHOLE pictures"});
}

}  // namespace

int ColmapKind::count() const { return int(words_of(parameters).size()); }

Lens lens_of(const ColmapCamera& camera, const std::string& where) {
  const ColmapKind& kind = *camera.kind;
  const std::vector<std::string> names = words_of(kind.parameters);
  Lens lens;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double value = camera.params.at(i);
    if (!std::isfinite(value))
      fail({where, "a parameter of the camera is not finite", "finite numbers", number(value), ""});
    if (std::optional<double>* place = place_of(names[i], lens))
      *place = value;
    else if (names[i] == "w" || (names[i] == "0" && value != 0))
      fail_lens(kind,
                names[i] == "w" ? kind.name : "parameter " + std::to_string(i + 1) + " is " + number(value),
                where);
  }
  if (!lens.fl_y) lens.fl_y = lens.fl_x;
  lens.w = camera.width;
  lens.h = camera.height;
  lens.scaled = true;
  if (kind.fisheye) lens.fisheye = true;
  return lens;
}

const ColmapKind* find_kind(std::int64_t id) {
  for (const ColmapKind& kind : kKinds)
    if (kind.id == id) return &kind;
  return nullptr;
}

const ColmapKind* find_kind(const std::string& name) {
  for (const ColmapKind& kind : kKinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

}  // namespace splinevox::data
