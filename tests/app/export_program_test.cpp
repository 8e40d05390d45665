// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <filesystem>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox::test;
using splinevox::run::Json;

TEST_SUITE("app/export_program") {
  TEST_CASE("a part of a shot says its times; info says what the folder holds and from which run") {
    const SmallRun small;
    const std::string out = small.path("vdb");
    const auto exported = [&](const std::string& frames, const std::vector<std::string>& more) {
      std::vector<std::string> words{"export", small.run, "--out", out, "--frames", frames};
      words.insert(words.end(), more.begin(), more.end());
      return program(words);
    };
    const Ended part = exported("1050-1051", {"--at", "1001", "--seconds", "4"});
    CAPTURE(part.err);
    REQUIRE(part.code == 0);
    CHECK(contains(part.out,
                   "frame 1050 shows time 0.5104, frame 1051 time 0.5208; the whole motion, time 0 to 1, "
                   "takes 4 s, frames 1001 to 1097"));
    const Ended same = exported("1053", {"--at", "1001-1097"});
    CHECK(contains(same.out, "the folder holds 3 frames of this shot now: 1050-1051, 1053"));

    const Ended text = program({"info", out});
    REQUIRE(text.code == 0);
    CHECK(contains(text.out, "3 frames (1050-1051, 1053)"));
    CHECK(contains(text.out, "profile blender"));
    CHECK(contains(text.out, "not there: 1052"));
    CHECK(contains(text.out, "of the run " + small.run));
    const Json j = Json::parse(program({"info", out, "--json"}).out);
    CHECK(j["frames"] == Json({1050, 1051, 1053}));
    CHECK(j["at"] == 1001);
    CHECK(j["fps"] == 24);
    CHECK(j["seconds"] == 4);
    CHECK(j["times"][0].get<double>() == doctest::Approx(49 / 96.0));
    CHECK(j["box"][0][0].get<double>() < j["box"][1][0].get<double>());
    CHECK(j["grids"][0]["name"] == "density");
    CHECK(j["bytes"].get<double>() > j["bytes_a_frame"].get<double>());
    CHECK(j["finished"] == true);

    const Ended other = exported("1050-1051", {"--at", "1001", "--seconds", "4", "--profile", "usd"});
    CHECK(other.code == 2);
    CHECK(contains(other.err, "profile blender"));
    CHECK(exported("1050-1051", {"--at", "1001", "--seconds", "4", "--profile", "usd", "--afresh"}).code ==
          0);
    CHECK(Json::parse(program({"info", out, "--json"}).out)["profile"] == "usd");
    CHECK_FALSE(std::filesystem::exists(out + "/load_in_blender.py"));  // it would show the new frames
  }

  TEST_CASE("frames without matter are counted aloud, and frames are whole numbers for programs") {
    const SmallRun small;
    const Ended e = program(
        {"export", small.run, "--out", small.path("empty"), "--frames", "1-2", "--voxel-size", "100"});
    CAPTURE(e.out);
    CHECK(e.code == 0);
    CHECK(contains(e.out, "2 of 2 frames hold no matter: --voxel-size or --min-alpha is too large"));
    const Ended events =
        program({"export", small.run, "--out", small.path("full"), "--frames", "1", "--json"});
    CHECK(contains(events.out, "\"frame\":1,"));
    CHECK_FALSE(contains(events.out, "\"frame\":1.0"));
  }

  TEST_CASE("points are a number or a table, and what is neither is refused by name") {
    const SmallRun small;
    const auto exported = [&](const std::string& points) {
      return program({"export", small.run, "--out", small.path("points"), "--profile", "usd", "--frames",
                      "1-2", "--points", points});
    };
    CHECK(contains(exported("0").err, "this is no number of points"));
    CHECK(contains(exported(small.path("none.csv")).err, "none.csv"));
    const std::string table = small.path("table.csv");
    std::ofstream(table) << "x,y,z,id\n0,0,0,7\n0.1,0,0,b 2\n";
    CHECK(contains(exported(table).err, "whole numbers for the column id"));
    std::ofstream(table) << "x,y,z,id\n0,0,0,7\n0.1,0,0,9\n";
    const Ended e = exported(table);
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    CHECK(contains(e.out, "points.usda: 2 points through 2 frames"));
    CHECK(contains(slurp(small.path("points/points.usda")), "int64[] ids = [7, 9]"));
  }

  TEST_CASE("lengths given twice, motions behind the frames and tiny voxels are refused by name") {
    const SmallRun small;
    const auto refusal = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words{"export", small.run, "--out", small.path("vdb"), "--frames", "3-4"};
      words.insert(words.end(), more.begin(), more.end());
      const Ended e = program(words);
      CHECK(e.code == 2);
      return e.err;
    };
    CHECK(contains(refusal({"--at", "1-9", "--seconds", "2"}),
                   "--at: the length of the motion is given twice"));
    CHECK(contains(refusal({"--at", "4"}), "--at: is out of range"));
    CHECK(contains(refusal({"--at", "2-2"}), "--at: a motion takes more than one frame"));
    CHECK(contains(refusal({"--at", "two"}), "--at"));
    CHECK(contains(refusal({"--voxel-size", "1e-50"}), "--voxel-size: is too small for the model's box"));
  }
}
