// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_mesh.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "io/scratch.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/on_threads.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp, test::spit;

namespace {

/// A reader of its own for the one layout that is written.
ColorMesh parse_ply(const std::string& bytes) {
  const std::string end = "end_header\n";
  const std::size_t start = bytes.find(end);
  REQUIRE(start != std::string::npos);
  std::size_t vertices = 0, faces = 0;
  std::istringstream header(bytes.substr(0, start));
  std::string line, properties;
  std::getline(header, line);
  CHECK(line == "ply");
  std::getline(header, line);
  CHECK(line == "format binary_little_endian 1.0");
  while (std::getline(header, line)) {
    if (line.starts_with("element vertex ")) vertices = std::stoul(line.substr(15));
    if (line.starts_with("element face ")) faces = std::stoul(line.substr(13));
    if (line.starts_with("property ")) properties += line.substr(9) + ";";
  }
  CHECK(properties ==
        "float x;float y;float z;uchar red;uchar green;uchar blue;list uchar int vertex_indices;");
  REQUIRE(bytes.size() == start + end.size() + 15 * vertices + 13 * faces);
  const char* p = bytes.data() + start + end.size();
  ColorMesh mesh;
  mesh.points.resize(vertices);
  mesh.colors.resize(vertices);
  mesh.triangles.resize(faces);
  for (std::size_t i = 0; i < vertices; ++i, p += 15) {
    float xyz[3];
    std::memcpy(xyz, p, 12);
    mesh.points[i] = {xyz[0], xyz[1], xyz[2]};
    std::memcpy(mesh.colors[i].data(), p + 12, 3);
  }
  for (std::size_t i = 0; i < faces; ++i, p += 13) {
    CHECK(p[0] == 3);
    std::memcpy(mesh.triangles[i].data(), p + 1, 12);
    for (const std::uint32_t v : mesh.triangles[i]) REQUIRE(v < vertices);
  }
  return mesh;
}

ColorMesh parse_obj(const std::string& text) {
  ColorMesh mesh;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vec3 p;
      float c[3];
      words >> p.x >> p.y >> p.z >> c[0] >> c[1] >> c[2];
      REQUIRE(bool(words));
      mesh.points.push_back(p);
      mesh.colors.push_back({std::uint8_t(std::lround(255 * c[0])), std::uint8_t(std::lround(255 * c[1])),
                             std::uint8_t(std::lround(255 * c[2]))});
    } else if (kind == "f") {
      std::array<std::uint32_t, 3> t;
      words >> t[0] >> t[1] >> t[2];
      REQUIRE(bool(words));
      for (std::uint32_t& v : t) REQUIRE(v-- >= 1);
      mesh.triangles.push_back(t);
    } else
      CHECK(kind == "#");
  }
  return mesh;
}

/// A ball about `centre` whose density falls along the radius, coloured by position, on a lattice that is off
/// zero.
struct Ball {
  Vec3d centre{0.3, -0.2, 0.1};
  double radius = 0.4, spacing = 0.04, slope = 100, iso = 20;
  VdbGrid density, color;

  Ball() {
    density.name = "density";
    color.name = "color";
    color.width = 3;
    const Vec3d origin = centre - Vec3d{0.613, 0.613, 0.613};
    for (VdbGrid* g : {&density, &color}) {
      g->spacing = spacing;
      g->origin = origin;
    }
    for (int b = 0; b < 64; ++b) {
      const Int3 leaf = kBrick * Int3{b >> 4, b >> 2 & 3, b & 3};
      density.leaves.push_back(leaf);
      color.leaves.push_back(leaf);
      for (int i = 0; i < 512; ++i) {
        const Int3 v = leaf + Int3{i >> 6, i >> 3 & 7, i & 7};
        const Vec3d x = origin + spacing * Vec3d{double(v.x), double(v.y), double(v.z)};
        density.values.push_back(float(std::max(0.0, iso + slope * (radius - length(x - centre)))));
        const Vec3 c = color_at(x);
        for (int a = 0; a < 3; ++a) color.values.push_back(c[a]);
      }
    }
  }
  Vec3 color_at(Vec3d x) const {
    return {float(0.5 + x.x - centre.x), float(0.5 + (x.y - centre.y) / 2), 0.25f};
  }
};

void check_closed(const ColorMesh& mesh, int expected_euler) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::set<std::uint32_t> used;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      used.insert(t[k]);
    }
  int open = 0;
  for (const auto& [edge, n] : edges) {
    const auto other = edges.find({edge.second, edge.first});
    open += n != 1 || other == edges.end() || other->second != 1;
  }
  CHECK(open == 0);
  CHECK(used.size() == mesh.points.size());
  CHECK(int(used.size()) - int(edges.size() / 2) + int(mesh.triangles.size()) == expected_euler);
}

double signed_volume(const ColorMesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = cast<double>(mesh.points[t[0]]), b = cast<double>(mesh.points[t[1]]),
                c = cast<double>(mesh.points[t[2]]);
    volume +=
        (a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)) / 6;
  }
  return volume;
}

}  // namespace

TEST_SUITE("io/export_mesh") {
  TEST_CASE("a ball is one closed surface of its radius, seen from outside, in its colours") {
    const Ball ball;
    const ColorMesh mesh = parse_ply(ply_bytes(make_mesh(ball.density, ball.color, ball.iso, false)));
    REQUIRE(mesh.points.size() > 500);
    check_closed(mesh, 2);
    const double expected = 4.0 / 3 * 3.14159265 * std::pow(ball.radius, 3);
    CHECK(signed_volume(mesh) == doctest::Approx(expected).epsilon(0.02));
    double off = 0, color_off = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const Vec3d x = cast<double>(mesh.points[i]);
      off = std::max(off, std::abs(length(x - ball.centre) - ball.radius));
      const Vec3 c = ball.color_at(x);
      for (int a = 0; a < 3; ++a)
        color_off = std::max(color_off, std::abs(double(mesh.colors[i][std::size_t(a)]) - 255.0 * c[a]));
    }
    CHECK(off < 0.25 * ball.spacing);
    CHECK(color_off <= 0.51);
  }

  TEST_CASE(
      "scene-linear colours are encoded, because eight bits are read as display values; nothing is an empty "
      "mesh") {
    const Ball ball;
    const ColorMesh mesh = make_mesh(ball.density, ball.color, ball.iso, true);
    CHECK(int(mesh.colors[0][2]) == 137);  // sRGB of 0.25
    const ColorMesh none = parse_ply(ply_bytes(make_mesh(ball.density, ball.color, 1e6, false)));
    CHECK(none.points.empty());
    CHECK(none.triangles.empty());
  }

  TEST_CASE(
      "an export writes one beside every frame, unshifted, lists it, keeps it, and writes a damaged one "
      "again") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32);
    ExportOptions options;
    options.last = 2;
    options.mesh = true;
    std::vector<ExportResult> results;
    for (const int threads : {1, 3})
      results.push_back(test::on_threads(
          threads, [&] { return export_vdb(model, scratch.path(std::to_string(threads)), options); }));
    for (std::size_t f = 0; f < 2; ++f) {
      REQUIRE(results[0].frames[f].beside.size() == 1);
      CHECK(results[0].frames[f].beside[0].digest == results[1].frames[f].beside[0].digest);
    }
    const std::string folder = scratch.path("1");
    CHECK(verify(folder).size() == 5);  // two frames, two meshes, Blender's script
    // The ball of blob_model moves by minus its shift; the profile's half voxel is Cycles' own affair.
    for (int f = 0; f < 2; ++f) {
      const ColorMesh mesh = parse_ply(slurp(folder + "/mesh_000" + std::to_string(f + 1) + ".ply"));
      CHECK(double(mesh.points.size()) == results[0].frames[std::size_t(f)].beside[0].figures.at("vertices"));
      check_closed(mesh, 2);
      Vec3d lo{9, 9, 9}, hi{-9, -9, -9};
      for (const Vec3& p : mesh.points)
        for (int a = 0; a < 3; ++a) {
          lo[a] = std::min<double>(lo[a], p[a]);
          hi[a] = std::max<double>(hi[a], p[a]);
        }
      const Vec3 moved = Vec3{0.1f, -0.05f, 0} - float(f) * Vec3{-0.5f, 0.1f, 0.2f};
      const float spacing = model.radiance.raw.topology->lattice.spacing;
      for (int a = 0; a < 3; ++a) CHECK(std::abs((lo[a] + hi[a]) / 2 - moved[a]) < 0.3 * spacing);
    }
    options.mesh_format = "obj";
    export_vdb(model, scratch.path("obj"), options);
    const ColorMesh text = parse_obj(slurp(scratch.path("obj/mesh_0002.obj"))),
                    binary = parse_ply(slurp(folder + "/mesh_0002.ply"));
    CHECK(text.points == binary.points);
    CHECK(text.colors == binary.colors);
    CHECK(text.triangles == binary.triangles);
    CHECK(verify(scratch.path("obj")).size() == 5);
    options.mesh_format = "stl";
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("--mesh-format"), Error);
    options.mesh_format = "ply";
    spit(folder + "/mesh_0002.ply", "damaged");
    const ExportResult again = export_vdb(model, folder, options);
    CHECK(again.frames[0].kept);
    CHECK_FALSE(again.frames[1].kept);
    CHECK(again.frames[1].beside[0].digest == results[0].frames[1].beside[0].digest);
    options.mesh_alpha = options.min_alpha / 2;
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("--mesh-alpha"), Error);
  }
}
