// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox::test;
using splinevox::run::Json;

TEST_SUITE("app/import_program") {
  TEST_CASE("a run goes out as splats and comes back as a sequence that info and verify know") {
    const SmallRun small;
    const std::string splats = small.path("splats"), vdb = small.path("vdb");
    const Ended out =
        program({"export", small.run, "--out", splats, "--profile", "splats", "--frames", "7-8"});
    CAPTURE(out.err);
    REQUIRE(out.code == 0);
    CHECK(program({"verify", splats}).code == 0);
    const Ended back =
        program({"import", splats, "--out", vdb, "--profile", "houdini", "--voxel-size", "0.1"});
    CAPTURE(back.err);
    REQUIRE(back.code == 0);
    CHECK(contains(back.out, "2 frames"));
    CHECK(contains(back.out, "splats a frame became"));
    CHECK(program({"verify", vdb}).code == 0);
    const Json j = Json::parse(program({"info", vdb, "--json"}).out);
    CHECK(j["frames"] == Json({7, 8}));
    CHECK(j["profile"] == "houdini");
    CHECK(j["settings"]["splats"] == splats);
    CHECK(contains(program({"info", splats}).out, "profile splats"));

    const Ended again = program({"import", splats, "--out", vdb, "--profile", "usd"});
    CHECK(again.code == 2);
    CHECK(contains(again.err, "profile houdini"));
    CHECK(contains(program({"import", splats, "--out", splats}).err, "the splats are in this folder"));
    CHECK(contains(program({"import", splats, "--out", small.run}).err, "this is the folder of a run"));
    CHECK(contains(program({"import", small.data, "--out", vdb}).err, "holds no splats"));
    std::filesystem::copy_file(splats + "/frame_0007.ply", splats + "/average.ply");
    CHECK(contains(program({"import", splats, "--out", small.path("mixed")}).err,
                   "average.ply: has no number, and others have one"));
    std::filesystem::remove(splats + "/average.ply");
    CHECK(contains(program({"import", splats, "--out", vdb, "--box", "1,2,3"}).err,
                   "--box: this is not a box"));
    CHECK(contains(program({"import", splats, "--out", vdb, "--box", "1,2,3,0,4,5"}).err,
                   "--box: is out of range"));
  }
}
