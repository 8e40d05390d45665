// SPDX-License-Identifier: Apache-2.0
// The .usda stage beside a sequence, and what Unreal's importer is given.
#include <doctest/doctest.h>

#include <algorithm>
#include <regex>

#include "io/scratch.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

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
