// SPDX-License-Identifier: Apache-2.0
#include "io/export/usd_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "io/export/usd_text.hpp"
#include "math/srgb.hpp"

namespace splinevox {
namespace {

using Rows = std::vector<std::vector<Vec3>>;  ///< [frames][points]

/// "[a, b, c]", each as `write` adds it to the text.
template <class Values, class Write>
std::string list(const Values& values, const Write& write) {
  std::string text = "[";
  for (const auto& value : values) {
    if (text.size() > 1) text += ", ";
    write(std::back_inserter(text), value);
  }
  return text + "]";
}

std::string vectors(const std::vector<Vec3>& values) {
  return list(values, [](auto out, const Vec3& v) { fmt::format_to(out, "({}, {}, {})", v.x, v.y, v.z); });
}

template <class Values>
std::string numbers(const Values& values) {
  return list(values, [](auto out, auto v) { fmt::format_to(out, "{}", v); });
}

/// Colours as USD has them: linear. Five digits tell 16 bits apart. @param values  display values, 0 to 1
std::string display_color(const std::vector<Vec3>& values) {
  return "    color3f[] primvars:displayColor = " +
         list(values,
              [](auto out, const Vec3& c) {
                fmt::format_to(out, "({:.5g}, {:.5g}, {:.5g})", srgb_to_linear(c.x), srgb_to_linear(c.y),
                               srgb_to_linear(c.z));
              }) +
         " (\n        interpolation = \"vertex\"\n    )\n";
}

std::string extent(const std::vector<Vec3>& points, float beyond) {
  Vec3 lo = points.front(), hi = lo;
  for (const Vec3& p : points)
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], p[a]);
      hi[a] = std::max(hi[a], p[a]);
    }
  const Vec3 margin{beyond, beyond, beyond};
  return vectors({lo - margin, hi + margin});
}

/// What Mesh and Points have in common. @param beyond  how far a point reaches, scene units
std::string point_based(Rows places, Rows velocities, const UsdPlay& play, float beyond) {
  for (auto& row : places)
    for (std::size_t v = 0; v < row.size(); ++v)
      if (length(row[v] - places[0][v]) <= play.still) row[v] = places[0][v];
  bool moves = false;
  for (auto& row : velocities)
    for (Vec3& v : row) {
      if (length(v) <= play.still * float(play.fps)) v = {};
      moves |= v != Vec3{};
    }
  // Programs take velocities only where places have a sample at the same time.
  const std::vector<std::size_t> samples = usd_samples(places.size(), [&](std::size_t i, std::size_t j) {
    return places[i] == places[j] && velocities[i] == velocities[j];
  });
  moves |= samples.size() > 1;
  const auto attribute = [&](const char* declaration, const auto& value) {
    return usd_attribute(declaration, play.frames, samples, !moves, value);
  };
  std::string text;
  if (!places[0].empty())
    text += attribute("float3[] extent", [&](std::size_t i) { return extent(places[i], beyond); });
  text += attribute("point3f[] points", [&](std::size_t i) { return vectors(places[i]); });
  if (moves)
    text += attribute("vector3f[] velocities", [&](std::size_t i) { return vectors(velocities[i]); });
  return text;
}

std::string layer(const char* type, const UsdPlay& play) {
  return usd_head(play.name, {play.frames.front(), play.frames.back(), play.fps}) +
         fmt::format("def {} \"{}\"\n{{\n", type, play.name);
}

}  // namespace

std::string usd_mesh(CarriedMesh carried, const UsdPlay& play) {
  const ColorMesh& mesh = carried.mesh;
  std::vector<Vec3> colors;
  for (const auto& c : mesh.colors)
    colors.push_back((1.0f / 255) * Vec3{float(c[0]), float(c[1]), float(c[2])});
  std::string text = layer("Mesh", play);
  text += "    uniform bool doubleSided = 1\n";  // where matter leaves the box the surface is open
  text += "    int[] faceVertexCounts = " + numbers(std::vector<int>(mesh.triangles.size(), 3)) + "\n";
  text += "    int[] faceVertexIndices = " +
          list(mesh.triangles,
               [](auto out, const auto& t) { fmt::format_to(out, "{}, {}, {}", t[0], t[1], t[2]); }) +
          "\n";
  text += "    uniform token orientation = \"rightHanded\"\n";
  text += point_based(std::move(carried.places), std::move(carried.velocities), play, 0);
  text += display_color(colors);
  return text + "    uniform token subdivisionScheme = \"none\"\n}\n";
}

std::string usd_points(const CarriedPoints& carried, const UsdPlay& play, float width) {
  std::string text = layer("Points", play);
  text += "    int64[] ids = " + numbers(carried.ids) + "\n";
  text += point_based(carried.places, carried.velocities, play, width / 2) + display_color(carried.colors);
  if (carried.untracked > 0) {
    const auto samples = usd_samples(carried.lost.size(), [&](std::size_t i, std::size_t j) {
      return carried.lost[i] == carried.lost[j];
    });
    text += "    int[] primvars:folded (\n        interpolation = \"vertex\"\n    )\n";
    text += usd_attribute("int[] primvars:folded", play.frames, samples, false, [&](std::size_t i) {
      return numbers(std::vector<int>(carried.lost[i].begin(), carried.lost[i].end()));
    });
  }
  return text +
         fmt::format("    float[] widths = [{}] (\n        interpolation = \"constant\"\n    )\n}}\n", width);
}

}  // namespace splinevox
