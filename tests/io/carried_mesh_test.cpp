// SPDX-License-Identifier: Apache-2.0
#include "io/export/carried_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/scratch.hpp"
#include "math/srgb.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/on_threads.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp;
using Json = nlohmann::json;

namespace {

const Vec3 kBlobShift{-0.5f, 0.1f, 0.2f};  // of blob_model at the end: the blob moves by minus it

/// A reader of its own for glTF binaries, which holds them to the format's rules.
struct Glb {
  Json head;
  std::string bytes;

  explicit Glb(const std::string& file) {
    REQUIRE(file.size() >= 20);
    CHECK(file.substr(0, 4) == "glTF");
    CHECK(word(file, 4) == 2);
    CHECK(word(file, 8) == file.size());
    const std::size_t text = word(file, 12);
    CHECK(text % 4 == 0);
    CHECK(file.substr(16, 4) == "JSON");
    head = Json::parse(file.substr(20, text));
    if (20 + text == file.size()) return;
    const std::size_t size = word(file, 20 + text);
    CHECK(size % 4 == 0);
    CHECK(file.substr(24 + text, 4) == std::string("BIN\0", 4));
    bytes = file.substr(28 + text);
    REQUIRE(bytes.size() == size);
    CHECK(head["buffers"][0]["byteLength"] == size);
  }
  static std::uint32_t word(const std::string& from, std::size_t at) {
    std::uint32_t w = 0;
    std::memcpy(&w, from.data() + at, 4);
    return w;
  }
  template <class T>
  std::vector<T> view(const Json& number) const {
    const Json& v = head["bufferViews"].at(number.get<std::size_t>());
    const std::size_t offset = v["byteOffset"], size = v["byteLength"];
    REQUIRE(offset + size <= bytes.size());
    REQUIRE(size % sizeof(T) == 0);
    CHECK(offset % 4 == 0);
    std::vector<T> out(size / sizeof(T));
    std::memcpy(out.data(), bytes.data() + offset, size);
    return out;
  }
  const Json& accessor(const Json& number) const { return head["accessors"].at(number.get<std::size_t>()); }

  const Json& primitive() const { return head["meshes"][0]["primitives"][0]; }
  std::vector<Vec3> points() const {
    const Json& a = accessor(primitive()["attributes"]["POSITION"]);
    const auto out = view<Vec3>(a["bufferView"]);
    REQUIRE(out.size() == a["count"]);
    return out;
  }
  /// Of a morph target: what it adds, and how many vertices it has values of.
  std::pair<std::vector<Vec3>, std::size_t> target(std::size_t frame) const {
    const Json& a = accessor(primitive()["targets"].at(frame)["POSITION"]);
    std::vector<Vec3> out(a["count"], Vec3{});
    const auto rows = view<std::uint32_t>(a["sparse"]["indices"]["bufferView"]);
    const auto values = view<Vec3>(a["sparse"]["values"]["bufferView"]);
    REQUIRE(rows.size() == a["sparse"]["count"]);
    REQUIRE(rows.size() == values.size());
    CHECK(std::is_sorted(rows.begin(), rows.end(), std::less_equal<>()));  // each once
    for (std::size_t i = 0; i < rows.size(); ++i) out.at(rows[i]) = values[i];
    for (int c = 0; c < 3; ++c) {  // the format asks for the bounds that values have
      const auto [lo, hi] = std::minmax_element(out.begin(), out.end(),
                                                [c](const Vec3& v, const Vec3& w) { return v[c] < w[c]; });
      CHECK(a["min"][std::size_t(c)].get<float>() == (*lo)[c]);
      CHECK(a["max"][std::size_t(c)].get<float>() == (*hi)[c]);
    }
    return {out, rows.size()};
  }
};

ExportOptions three_frames() {
  ExportOptions options;
  options.last = 3;
  options.mesh = true;
  options.mesh_format = "glb";
  return options;
}

ColorMesh triangle() {
  return {
      {{0.1f, 0, 0}, {0.2f, 0, 0}, {0.1f, 0.1f, 0}}, {{0, 55, 255}, {0, 55, 255}, {0, 55, 255}}, {{0, 1, 2}}};
}

}  // namespace

TEST_SUITE("io/carried_mesh") {
  TEST_CASE(
      "an export has one mesh for all frames, which goes where the matter goes, and the same bytes again") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32);
    for (const int threads : {1, 3})
      test::on_threads(threads,
                       [&] { export_vdb(model, scratch.path(std::to_string(threads)), three_frames()); });
    const std::string file = slurp(scratch.path("1/mesh.glb"));
    CHECK(file == slurp(scratch.path("3/mesh.glb")));
    CHECK(verify(scratch.path("1")).size() == 5);  // three frames, the mesh, Blender's script

    const Glb glb(file);
    const std::vector<Vec3> points = glb.points();
    REQUIRE(points.size() > 300);
    const float spacing = model.radiance.raw.topology->lattice.spacing;
    for (std::size_t f = 0; f < 3; ++f) {
      const std::vector<Vec3> by = glb.target(f).first;
      REQUIRE(by.size() == points.size());
      const Vec3 expected = -0.5f * float(f) * kBlobShift;
      float off = 0;
      for (const Vec3& v : by) off = std::max(off, length(v - expected));
      CHECK(off < 0.05f * spacing);
    }
    CHECK(glb.target(0).second == 1);  // the first frame is the mesh itself
    CHECK(glb.head["meshes"][0]["extras"]["targetNames"] == Json({"frame_1", "frame_2", "frame_3"}));
    const Json& sampler = glb.head["animations"][0]["samplers"][0];
    const auto seconds = glb.view<float>(glb.accessor(sampler["input"])["bufferView"]);
    CHECK(seconds == std::vector<float>{0, 1 / 24.0f, 2 / 24.0f});
    const auto weights = glb.view<float>(glb.accessor(sampler["output"])["bufferView"]);
    CHECK(weights == std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1});
    // Z up becomes Y up: a quarter turn back about x.
    const Json& turn = glb.head["nodes"][0]["rotation"];
    CHECK(turn[0].get<double>() == doctest::Approx(-std::sqrt(0.5)));
    CHECK(turn[3].get<double>() == doctest::Approx(std::sqrt(0.5)));
  }

  TEST_CASE("frames that are added later are in it, and the first of all is the one that is carried") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32);
    ExportOptions options = three_frames();
    options.at = 1;
    options.seconds = 2 / 24.0;
    options.first = 3;
    export_vdb(model, scratch.path("out"), options);
    options.first = options.last = 1;
    const ExportResult result = export_vdb(model, scratch.path("out"), options);
    REQUIRE(result.carried.size() == 1);
    CHECK(result.carried[0].figures.at("frames") == 2);
    const Glb glb(slurp(scratch.path("out/mesh.glb")));
    CHECK(glb.head["meshes"][0]["extras"]["targetNames"] == Json({"frame_1", "frame_3"}));
    CHECK(glb.target(0).second == 1);
    CHECK(length(glb.target(1).first[0] + kBlobShift) < 0.01f);
  }

  TEST_CASE("a mesh that would not find room for all its frames is refused before the first of them") {
    const Scratch scratch;
    ExportOptions options = three_frames();
    options.first = 0;
    options.last = 999'999;
    for (const char* format : {"glb", "usd"}) {
      options.mesh_format = format;
      try {
        export_vdb(blob_model(48), scratch.path("out"), options);
        FAIL("there was room");
      } catch (const Error& e) {
        CHECK(e.fault == Fault::memory);
        CHECK(e.problem.hint.find("--voxel-size") != std::string::npos);
      }
    }
    CHECK_FALSE(std::filesystem::exists(scratch.path("out/frame_0000.vdb")));
    options.mesh_format = "ply";  // as the message says
    options.last = 1;
    CHECK(export_vdb(blob_model(24), scratch.path("out"), options).finished);
  }

  TEST_CASE("what stands still has no values in any frame") {
    const Scratch scratch;
    export_vdb(blob_model(32, {.moves = false}), scratch.path("out"), three_frames());
    const Glb glb(slurp(scratch.path("out/mesh.glb")));
    for (std::size_t f = 0; f < 3; ++f) {
      CHECK(glb.target(f).second == 1);
      CHECK(glb.target(f).first[0] == Vec3{});
    }
  }

  TEST_CASE("vertices whose ways are not known follow their neighbours, from the known ones outwards") {
    // 0 and 1 are known, 2 lies beside both, 3 beside 1 and 2, 4 beside 2 and 3; 5 to 7 are a piece apart.
    const ColorMesh mesh{
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}, {9, 0, 0}, {9, 1, 0}, {8, 0, 0}},
        {},
        {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {5, 6, 7}}};
    std::vector<Vec3> places = mesh.points;
    places[0] = places[0] + Vec3{0, 0, 1};
    places[1] = places[1] + Vec3{0, 0, 3};
    places[2] = places[3] = {70, 70, 70};  // the ways that were lost
    std::vector<bool> known(8, false);
    known[0] = known[1] = true;
    follow_neighbours(mesh, known, places);
    CHECK(places[2].x == doctest::Approx(0));
    // Two of the triangles around 2 have the edge to 1.
    CHECK(places[2].z == doctest::Approx((1 + 2 * 3) / 3.0));
    CHECK(places[3].z == doctest::Approx(3));
    CHECK(places[4].z == doctest::Approx((7 / 3.0 + 3) / 2));  // one layer later
    for (std::size_t v = 5; v < 8; ++v) CHECK(places[v] == mesh.points[v]);
  }

  TEST_CASE("colours are linear, of 16 bits") {
    const CarriedMesh carried{triangle(), {triangle().points}, {}, 0};
    const Glb glb(glb_bytes(carried, {.name = "triangle", .frames = {"one"}, .seconds = {0}}));
    const Json& a = glb.accessor(glb.primitive()["attributes"]["COLOR_0"]);
    CHECK(a["normalized"] == true);
    const auto colors = glb.view<std::array<std::uint16_t, 4>>(a["bufferView"]);
    REQUIRE(colors.size() == 3);
    CHECK(colors[0][0] == 0);
    CHECK(colors[0][1] == std::lround(65535 * srgb_to_linear(55 / 255.0f)));
    CHECK(colors[0][2] == 65535);
    CHECK(colors[0][3] == 65535);
    CHECK(glb.head["materials"][0]["extensions"].contains("KHR_materials_unlit"));
  }

  TEST_CASE("no surface at all is a file without a mesh") {
    const Glb glb(glb_bytes({}, {.name = "nothing"}));
    CHECK(glb.bytes.empty());
    CHECK(glb.head["nodes"].size() == 1);
    for (const char* key : {"meshes", "accessors", "bufferViews", "buffers", "animations"})
      CHECK_FALSE(glb.head.contains(key));
  }
}
