// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/ball_scene.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/usd_numbers.hpp"

using namespace splinevox;
using namespace splinevox::test;
using Json = nlohmann::json;

namespace {

/// What is read goes through the nearest rotation, which rounds.
void check_same(const Json& a, const Json& b) {
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t k = 0; k < 4; ++k)
      CHECK(a["transform_matrix"][r][k].get<double>() ==
            doctest::Approx(b["transform_matrix"][r][k].get<double>()));
}

}  // namespace

TEST_SUITE("cli/cameras") {
  TEST_CASE("cameras as files: JSON that render reads as the same, and USD that sees the same") {
    const SmallRun small;
    const auto written = [&](const std::string& camera, const std::string& out) {
      const Ended e = program({"render", small.run, "--out", small.path(out), "--format", "cameras",
                               "--camera", camera, "--frames", "3-6", "--fps", "25"});
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      CHECK(contains(e.out, "4 cameras"));
      return Json::parse(slurp(small.path(out) + "/cameras.json"));
    };
    const Json once = written("dataset:train", "once");
    REQUIRE(once["frames"].size() == 4);
    CHECK(once["fps"] == 25);
    CHECK(once["frames"][0]["transform_matrix"] != once["frames"][3]["transform_matrix"]);
    const Json again = written(small.path("once") + "/cameras.json", "again");
    const std::string usd = slurp(small.path("once") + "/cameras.usda");
    CHECK(contains(usd, "startTimeCode = 3\n"));
    for (std::size_t i = 0; i < 4; ++i) {
      const Json& c = once["frames"][i];
      CHECK(c["frame"] == 3 + int(i));
      CHECK(again["frames"][i]["fl_x"] == c["fl_x"]);
      const auto value = [&](const char* name) { return usd_numbers(usd, name, 3 + int(i)).at(0); };
      const double focal = value("focalLength"), wide = value("horizontalAperture"),
                   high = value("verticalAperture"), right = value("horizontalApertureOffset"),
                   up = value("verticalApertureOffset");
      CHECK((right - wide / 2) / focal == doctest::Approx(-c["cx"].get<double>() / c["fl_x"].get<double>()));
      CHECK((up + high / 2) / focal == doctest::Approx(c["cy"].get<double>() / c["fl_y"].get<double>()));
      CHECK(wide / focal == doctest::Approx(c["w"].get<double>() / c["fl_x"].get<double>()));
      CHECK(high / focal == doctest::Approx(c["h"].get<double>() / c["fl_y"].get<double>()));
      const std::vector<double> rows = usd_numbers(usd, "xformOp:transform", 3 + int(i));
      REQUIRE(rows.size() == 16);
      for (std::size_t r = 0; r < 4; ++r)
        for (std::size_t k = 0; k < 4; ++k) {
          const double ours = c["transform_matrix"][r][k],
                       back = again["frames"][i]["transform_matrix"][r][k];
          CHECK(rows[4 * k + r] == doctest::Approx(ours));
          CHECK(back == doctest::Approx(ours));
        }
    }
  }

  TEST_CASE("pictures that no render wrote are not replaced, earlier ones are") {
    const SmallRun small;
    const auto rendered = [&](const std::string& out, const std::string& format) {
      return program({"render", small.run, "--out", small.path(out), "--format", format, "--camera", "held",
                      "--frames", "1-2"});
    };
    for (const auto& [format, name] : {std::pair{"png", "rgb_0002.png"},
                                       {"exr", "frame_0002.exr"},
                                       {"mp4", "rgb.mp4"},
                                       {"cameras", "cameras.json"}}) {
      CAPTURE(format);
      if (format == std::string("mp4") && found_in_path("ffmpeg").empty()) continue;
      const std::string out = std::string("of_") + format, file = small.path(out) + "/" + name;
      write_text(file, "mine");
      const Ended refused = rendered(out, format);
      CHECK(refused.code == 2);
      CHECK(contains(refused.err, "`render` did not write this file and would replace it"));
      CHECK(slurp(file) == "mine");
      std::filesystem::remove(file);
      write_text(small.path(out) + "/notes.txt", "mine");
      for (int again = 0; again < 2; ++again) CHECK(rendered(out, format).code == 0);
      CHECK(slurp(file) != "mine");
      CHECK_FALSE(slurp(file).empty());
      CHECK(slurp(small.path(out) + "/notes.txt") == "mine");
    }
  }

  TEST_CASE("cameras with numbers are those of their frames, whatever part of a shot is asked for") {
    const SmallRun small;
    const auto written = [&](const std::string& camera, const std::vector<std::string>& frames,
                             const std::string& out) {
      std::vector<std::string> words{"render",   small.run, "--out",    small.path(out),
                                     "--format", "cameras", "--camera", camera};
      words.insert(words.end(), frames.begin(), frames.end());
      const Ended e = program(words);
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      return std::pair{Json::parse(slurp(small.path(out) + "/cameras.json"))["frames"], e.out + e.err};
    };
    const auto [part, said] = written("dataset:train", {"--frames", "3-6", "--at", "1-12"}, "part");
    REQUIRE(part.size() == 4);
    CHECK(part[0]["transform_matrix"] != part[3]["transform_matrix"]);
    const std::string file = small.path("part") + "/cameras.json";
    const auto [same, ignored] = written(file, {"--frames", "3-6", "--at", "1-12"}, "same");
    REQUIRE(same.size() == part.size());
    for (std::size_t i = 0; i < part.size(); ++i) {
      check_same(same[i], part[i]);
      CHECK(same[i]["frame"] == part[i]["frame"]);
      CHECK(same[i]["time"] == part[i]["time"]);
    }
    // Others have the camera before them, or the first, and are said. A frame behind the motion has its own.
    const auto [more, notes] = written(file, {"--frames", "2-8", "--at", "1-4"}, "more");
    REQUIRE(more.size() == 7);
    for (std::size_t i = 0; i < 7; ++i) check_same(more[i], part[std::size_t(std::clamp(int(i) - 1, 0, 3))]);
    // Where no number fits, as where Blender counts from 1, they are spread over the shot as ever.
    const auto [spread, quiet] = written(file, {"--frames", "1001-1008"}, "spread");
    REQUIRE(spread.size() == 8);
    for (std::size_t i = 0; i < 8; ++i) check_same(spread[i], part[i / 2]);
    CHECK_FALSE(contains(quiet, "no camera of their number"));
    CHECK(
        contains(notes, "3 of 7 frames have no camera of their number in the file, which has 4 from 3 to 6"));
  }

  TEST_CASE("the stage of an export shows cameras that come into its folder, before it or after") {
    const SmallRun small;
    const std::string folder = small.path("usd");
    ExportOptions options;
    options.profile = "usd";
    options.first = 3;
    options.last = 5;
    options.mesh = true;
    options.points.chosen = 5;
    const auto exported = [&] { export_vdb(blob_model(24), folder, options); };
    const auto layers = [&] {
      const std::string stage = slurp(folder + "/sequence.usda");
      const std::size_t at = stage.find("    subLayers = [@./cameras.usda@]\n");
      return at != std::string::npos && at < stage.find("\n)\n") && at == stage.rfind("    subLayers");
    };
    exported();
    CHECK_FALSE(layers());
    for (int again = 0; again < 2; ++again) {
      const Ended e = program({"render", small.run, "--out", folder, "--format", "cameras", "--camera",
                               "dataset:train", "--frames", "3-5"});
      CHECK(e.code == 0);
      CHECK(contains(e.out, "shows them too"));
      CHECK(layers());
    }
    const auto whole = [&] {
      const std::vector<FileCheck> checks = verify(folder);
      return std::all_of(checks.begin(), checks.end(), [](const FileCheck& c) { return c.ok; });
    };
    CHECK(whole());
    exported();
    CHECK(layers());
    CHECK(whole());
    for (const char* fps : {"30", "24"}) {  // of another rate USD would play them at other times
      const Ended e = program({"render", small.run, "--out", folder, "--format", "cameras", "--camera",
                               "dataset:train", "--frames", "3-5", "--fps", fps});
      CHECK(e.code == 0);
      CHECK(contains(e.out, "has other frames a second") == (fps[0] == '3'));
      CHECK(layers() == (fps[0] != '3'));
      CHECK(whole());
    }

    // SPLINEVOX_TINYUSDZ is the folder of the npm package tinyusdz.
    const char* tiny = std::getenv("SPLINEVOX_TINYUSDZ");
    if (!tiny || found_in_path("node").empty()) {
      MESSAGE("skipped: no node, or no SPLINEVOX_TINYUSDZ, which would read the stage as another program");
      return;
    }
    const Ended read = Started({"node", SPLINEVOX_USD_READ, tiny, folder}).wait();
    CAPTURE(read.err);
    REQUIRE(read.code == 0);
    CHECK(contains(read.err, "meshes 1"));
    CHECK(contains(read.out, "def Camera \"splinevox_camera\""));
    CHECK(contains(read.out, "def Volume \"volume\""));
    const std::string mesh = slurp(folder + "/mesh.usda"), points = slurp(folder + "/points.usda");
    const std::string theirs = read.out.substr(read.out.find("def Mesh"));
    for (int frame = 3; frame <= 5; ++frame)
      for (const char* name : {"points", "velocities"}) {
        const std::vector<double> ours = usd_numbers(mesh, name, frame),
                                  back = usd_numbers(theirs, name, frame);
        REQUIRE(ours.size() > 300);
        REQUIRE(back.size() == ours.size());
        double off = 0;
        for (std::size_t i = 0; i < ours.size(); ++i) off = std::max(off, std::abs(ours[i] - back[i]));
        CHECK(off < 1e-6);
      }
    CHECK(usd_numbers(theirs, "faceVertexIndices", 3) == usd_numbers(mesh, "faceVertexIndices", 3));
    CHECK(usd_numbers(read.out.substr(read.out.find("def Points")), "widths", 3) ==
          usd_numbers(points, "widths", 3));
  }
}
