// SPDX-License-Identifier: Apache-2.0
#include "data/layouts.hpp"

#include <doctest/doctest.h>

#include "program.hpp"
#include "run/support.hpp"

/// Data sets of other layouts on the command line.
namespace {

using namespace splinevox::test;
using splinevox::run::Json;
const TrueLens kBent{11, 12, 5.5, 4.25, -0.12, 0.03, -0.004, 0, 0.002, -0.003};

TEST_SUITE("app/layouts") {
  TEST_CASE("info says what it understood, as text and as JSON") {
    const TempFolder folder;
    write_nerfies(folder.path(), true_cameras(kBent));
    const Ended text = program({"info", folder.str()});
    CAPTURE(text.out);
    CHECK(text.code == 0);
    for (const char* part :
         {"Nerfies / HyperNeRF, opaque pictures", "train     13 frames of 12x8", "test       3 frames",
          "times  0 to 15 in the data", "focal length 11 x 12 pixels (59 x 37 degrees)", "centre 5.5, 4.25",
          "brown distortion, up to", "places 16 cameras", "box    [", "note: pictures are those of rgb/2x",
          "note: the frames of val_ids are the test split"})
      CHECK_MESSAGE(contains(text.out, part), part);
    const Json j = Json::parse(program({"info", folder.str(), "--json"}).out);
    CHECK(j["format"] == "Nerfies / HyperNeRF");
    CHECK(j["alpha"] == false);
    CHECK(j["cameras"]["lens"]["distortion"]["model"] == "brown");
    CHECK(j["cameras"]["forward_facing"] == false);
    CHECK(j["box"].size() == 2);
  }

  TEST_CASE("convert writes a folder that train and eval take; what exists is left alone") {
    const TempFolder folder;
    const std::string in = folder.str() + "/in", out = folder.str() + "/out", run = folder.str() + "/run";
    write_nrnerf(in, true_cameras());
    const Ended convert = program({"convert", in, "--out", out});
    CAPTURE(convert.err);
    REQUIRE(convert.code == 0);
    CHECK(contains(convert.out, "16 pictures"));
    const Ended again = program({"convert", in, "--out", out});
    CHECK(again.code == 2);
    CHECK(contains(again.err, "there is something of that name already"));
    CHECK(contains(program({"info", out}).out, "NeRF / D-NeRF, opaque pictures"));
    CHECK(program({"convert", folder.str() + "/none", "--out", out}).code == 2);

    // The box is the data's own, in the configuration of the run; a run on the source itself is the same run.
    const auto train = [&](const std::string& data, const std::string& to) {
      return program({"train",       data,
                      "--out",       to,
                      "--preset",    "draft",
                      "--max-steps", "4",
                      "--set",       "sampling.rays=256",
                      "--set",       "grid.radiance=16,24,32",
                      "--set",       "grid.motion=4,8",
                      "--set",       "grid.motion_start=0,0.2",
                      "--effects",   "all",
                      "--threads",   "1"});
    };
    const Ended trained = train(out, run);
    CAPTURE(trained.err);
    REQUIRE(trained.code == 0);
    CHECK(contains(trained.err + trained.out, "the box is the data's own"));
    CHECK_FALSE(contains(slurp(run + "/config.toml"), "box = []"));
    REQUIRE(train(in, run + "2").code == 0);
    CHECK(Json::parse(slurp(run + "/metrics.json"))["loss"] ==
          Json::parse(slurp(run + "2/metrics.json"))["loss"]);
    const Ended eval = program({"eval", run + "2", "--json"});
    CAPTURE(eval.err);
    REQUIRE(eval.code == 0);
    CHECK(Json::parse(eval.out)["frames"].size() == 2);
    CHECK(program({"render", run + "2", "--out", folder.str() + "/film", "--camera", "dataset:test"}).code ==
          0);
    const Ended resumed = program({"train", in, "--out", run + "2", "--resume", "--threads", "1"});
    CAPTURE(resumed.err);
    CHECK(resumed.code == 0);
  }
}

}  // namespace
