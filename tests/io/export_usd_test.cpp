// SPDX-License-Identifier: Apache-2.0
// The .usda stage beside a sequence, and what Unreal's importer is given.
#include <doctest/doctest.h>

#include <algorithm>
#include <regex>

#include "io/export/usd_text.hpp"
#include "io/scratch.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/usd_numbers.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp;

namespace {

ExportOptions options_for(const char* profile, int first, int last) {
  ExportOptions o;
  o.profile = profile;
  o.first = first;
  o.last = last;
  return o;
}

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

/// Numbers of an attribute that has one value for all time, or of a frame of one that has samples.
std::vector<double> numbers(const std::string& text, const std::string& attribute, int frame = -1) {
  REQUIRE(count(text, "    " + attribute + (frame < 0 ? " = " : ".timeSamples = {")) == 1);
  return test::usd_numbers(text, attribute, frame);
}

std::vector<Vec3> vectors(const std::string& text, const std::string& attribute, int frame = -1) {
  const std::vector<double> flat = numbers(text, attribute, frame);
  REQUIRE(flat.size() % 3 == 0);
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < flat.size(); i += 3)
    out.push_back({float(flat[i]), float(flat[i + 1]), float(flat[i + 2])});
  return out;
}

}  // namespace

TEST_SUITE("io/export_usd") {
  TEST_CASE("the stage is this text, names every frame and holds what the frames show") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = options_for("usd", 9, 11);
    options.fps = 29.97;
    double reach = 0;
    export_vdb(model, scratch.folder(), options, [&](const ExportedFrame& f, int, int) {
      reach = std::max(reach, f.file.figures.at("velocity_padding"));
      return true;
    });
    CHECK(reach > 1);
    std::string text = slurp(scratch.path("sequence.usda"));
    std::smatch extent;
    const std::string number = "(-?[0-9.e-]+)",
                      corner = "\\(" + number + ", " + number + ", " + number + "\\)";
    REQUIRE(std::regex_search(text, extent, std::regex("\\[" + corner + ", " + corner + "\\]")));
    const float spacing = model.radiance.raw.topology->lattice.spacing;
    for (int a = 0; a < 3; ++a) {
      const float lo = std::stof(extent[std::size_t(1 + a)]), hi = std::stof(extent[std::size_t(4 + a)]);
      CHECK(lo == doctest::Approx(model.box.lo[a] - reach * spacing));
      CHECK(hi >= model.box.hi[a]);
      CHECK(hi <= model.box.hi[a] + (reach + 2) * spacing);
    }
    text.replace(std::size_t(extent.position()), std::size_t(extent.length()), "[EXTENT]");
    const auto field = [](const std::string& name, const std::string& type, const std::string& role) {
      return "\n    def OpenVDBAsset \"" + name + "\"\n    {\n        token fieldName = \"" + name +
             "\"\n        token fieldDataType = \"" + type +
             "\"\n        token fieldClass = \"fogVolume\"\n        token vectorDataRoleHint = \"" + role +
             "\"\n        asset filePath.timeSamples = {\n            9: @./frame_0009.vdb@,\n"
             "            10: @./frame_0010.vdb@,\n            11: @./frame_0011.vdb@,\n        }\n    }\n";
    };
    CHECK(text ==
          "#usda 1.0\n(\n    defaultPrim = \"splinevox\"\n"
          "    doc = \"Density is extinction per scene unit, colour is emitted per density, velocity is in "
          "scene units "
          "per second.\"\n"
          "    endTimeCode = 11\n    framesPerSecond = 29.97\n    metersPerUnit = 1\n    startTimeCode = 9\n"
          "    timeCodesPerSecond = 29.97\n    upAxis = \"Z\"\n)\n\n"
          "def Volume \"splinevox\"\n{\n    float3[] extent = [EXTENT]\n"
          "    rel field:density = </splinevox/density>\n    rel field:color = </splinevox/color>\n"
          "    rel field:velocity = </splinevox/velocity>\n" +
              field("density", "float", "None") + field("color", "float3", "Color") +
              field("velocity", "float3", "Vector") + "}\n");
    for (const char* name : {"frame_0009.vdb", "frame_0010.vdb", "frame_0011.vdb"}) {
      const VdbInfo info = inspect_vdb(scratch.path(name));
      REQUIRE(info.grids.size() == 3);
      CHECK(info.grids[0].name == "density");
      CHECK(info.grids[1].name == "color");
      CHECK(info.grids[2].name == "velocity");
    }
    const std::vector<FileCheck> checks = verify(scratch.folder());
    CHECK(checks.size() == 4);
    CHECK(std::all_of(checks.begin(), checks.end(), [](const FileCheck& c) { return c.ok; }));
  }

  TEST_CASE("a stage of a scene that stands still names no velocity") {
    const Scratch scratch;
    export_vdb(blob_model(16, {.moves = false}), scratch.folder(), options_for("usd", 1, 2));
    const std::string text = slurp(scratch.path("sequence.usda"));
    CHECK(count(text, "def OpenVDBAsset") == 2);
    CHECK(count(text, "velocity\"") == 0);
    CHECK(count(text, "rel field:") == 2);
    CHECK(count(text, "{") == count(text, "}"));
  }

  TEST_CASE("a stage with a mesh and points: one topology, which goes as fast and as far as the matter") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32);
    ExportOptions options = options_for("usd", 4, 6);
    options.mesh = true;
    options.points.chosen = 40;
    const ExportResult result = export_vdb(model, scratch.folder(), options);
    REQUIRE(result.carried.size() == 2);
    const std::vector<FileCheck> checks = verify(scratch.folder());
    CHECK(checks.size() == 6);
    CHECK(std::all_of(checks.begin(), checks.end(), [](const FileCheck& c) { return c.ok; }));
    const std::string stage = slurp(scratch.path("sequence.usda"));
    for (const char* part :
         {"def Xform \"splinevox\"\n", "    def Volume \"volume\"\n", "</splinevox/volume/density>",
          "    def Mesh \"mesh\" (\n        prepend references = @./mesh.usda@\n    )\n",
          "    def Points \"points\" (\n        prepend references = @./points.usda@\n    )\n"})
      CHECK_MESSAGE(stage.find(part) != std::string::npos, part);

    const std::string mesh = slurp(scratch.path("mesh.usda")), points = slurp(scratch.path("points.usda"));
    for (const char* part : {"defaultPrim = \"mesh\"", "startTimeCode = 4", "endTimeCode = 6",
                             "upAxis = \"Z\"", "uniform token subdivisionScheme = \"none\"",
                             "uniform token orientation = \"rightHanded\"", "uniform bool doubleSided = 1"})
      CHECK_MESSAGE(mesh.find(part) != std::string::npos, part);
    const std::vector<Vec3> first = vectors(mesh, "point3f[] points", 4);
    REQUIRE(first.size() > 300);
    const std::vector<double> counts = numbers(mesh, "int[] faceVertexCounts"),
                              corners = numbers(mesh, "int[] faceVertexIndices");
    CHECK(std::all_of(counts.begin(), counts.end(), [](double n) { return n == 3; }));
    CHECK(corners.size() == 3 * counts.size());
    CHECK(*std::max_element(corners.begin(), corners.end()) == double(first.size() - 1));
    CHECK(double(counts.size()) == result.carried[1].figures.at("triangles"));
    const float spacing = model.radiance.raw.topology->lattice.spacing;
    const Vec3 whole = -1.0f * Vec3{-0.5f, 0.1f, 0.2f};
    for (const auto& [text, count] : {std::pair(mesh, first.size()), std::pair(points, std::size_t(40))}) {
      const std::vector<Vec3> start = vectors(text, "point3f[] points", 4);
      CHECK(vectors(text, "color3f[] primvars:displayColor").size() == count);
      for (int f = 0; f < 3; ++f) {
        const std::vector<Vec3> places = vectors(text, "point3f[] points", 4 + f),
                                speeds = vectors(text, "vector3f[] velocities", 4 + f),
                                box = vectors(text, "float3[] extent", 4 + f);
        REQUIRE(places.size() == count);
        REQUIRE(speeds.size() == count);
        double far = 0, fast = 0, outside = 0;
        for (std::size_t v = 0; v < count; ++v) {
          far = std::max<double>(far, length(places[v] - start[v] - 0.5f * float(f) * whole));
          fast = std::max<double>(fast, length(speeds[v] - float(1 / options.length()) * whole));
          for (int a = 0; a < 3; ++a)
            outside = std::max<double>({outside, box[0][a] - places[v][a], places[v][a] - box[1][a]});
        }
        CHECK(far < 0.05 * spacing);
        CHECK(fast < 0.02 * length(whole) / options.length());
        CHECK(outside <= 0);
      }
    }
    CHECK(numbers(points, "int64[] ids").back() == 39);
    CHECK(float(numbers(points, "float[] widths").at(0)) == spacing);
    for (const Vec3& p : vectors(points, "point3f[] points", 4))
      CHECK(std::find(first.begin(), first.end(), p) != first.end());
    CHECK(points.find("primvars:folded") == std::string::npos);
  }

  TEST_CASE("parts have a mesh each, and what stands still has one value for all time") {
    const Scratch scratch;
    ExportOptions options = options_for("usd", 1, 3);
    options.mesh = true;
    export_vdb(blob_model(32, {.moves = false}), scratch.path("still"), options);
    const std::string still = slurp(scratch.path("still/mesh.usda"));
    CHECK(vectors(still, "point3f[] points").size() > 300);
    CHECK(vectors(still, "float3[] extent").size() == 2);
    CHECK(count(still, "velocities") == 0);
    CHECK(count(still, "timeSamples") == 0);
    options.clusters = 2;
    export_vdb(blob_model(32), scratch.path("parts"), options);
    const std::string stage = slurp(scratch.path("parts/sequence.usda"));
    CHECK(count(stage, "def Volume \"cluster_1\"") == 1);
    CHECK(count(stage, "def Mesh \"cluster_1_mesh\"") == 1);
    CHECK(count(slurp(scratch.path("parts/cluster_1_mesh.usda")), "def Mesh \"cluster_1_mesh\"") == 1);
  }

  TEST_CASE("points of a table are there at their own times, with their own numbers") {
    const Scratch scratch;
    ExportOptions options = options_for("houdini", 1, 3);
    const Vec3 begin{0.1f, -0.05f, 0.3f}, whole = -1.0f * Vec3{-0.5f, 0.1f, 0.2f};
    options.points.position = {begin, begin + whole};
    options.points.time = {0, 1};
    options.points.id = {70, -8};
    export_vdb(blob_model(32), scratch.folder(), options);
    const std::string points = slurp(scratch.path("points.usda"));
    CHECK(numbers(points, "int64[] ids") == std::vector<double>{70, -8});
    for (int f = 0; f < 3; ++f)
      for (const Vec3& p : vectors(points, "point3f[] points", 1 + f))
        CHECK(length(p - begin - 0.5f * float(f) * whole) < 2e-3f);
  }

  TEST_CASE("a frame is left out only if it is like both beside it") {
    const std::vector<int> values{5, 5, 5, 7, 7, 7, 8, 8};
    CHECK(usd_samples(values.size(), [&](std::size_t i, std::size_t j) { return values[i] == values[j]; }) ==
          std::vector<std::size_t>{0, 2, 3, 5, 6});
  }

  TEST_CASE("a mesh per frame is no part of the stage") {
    const Scratch scratch;
    ExportOptions options = options_for("usd", 1, 1);
    options.mesh = true;
    options.mesh_format = "ply";
    export_vdb(blob_model(24), scratch.folder(), options);
    CHECK(slurp(scratch.path("mesh_0001.ply")).starts_with("ply"));
    CHECK(count(slurp(scratch.path("sequence.usda")), "def Volume \"splinevox\"") == 1);
  }

  TEST_CASE("Unreal gets four channels, in files numbered without a gap") {
    const Scratch scratch;
    export_vdb(blob_model(24), scratch.folder(), options_for("unreal", 0, 2));
    for (const char* name : {"frame_0000.vdb", "frame_0001.vdb", "frame_0002.vdb"}) {
      const VdbInfo info = inspect_vdb(scratch.path(name));
      REQUIRE(info.grids.size() == 2);
      CHECK(info.grids[0].name == "density");
      CHECK(info.grids[0].type == "float");
      CHECK(info.grids[1].name == "Cd");
      CHECK(info.grids[1].type == "vec3s");
    }
    CHECK(verify(scratch.folder()).size() == 3);
  }
}
