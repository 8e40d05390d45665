// SPDX-License-Identifier: Apache-2.0
// Options whose effect no other test sees: what the program makes with them is what they say.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ball_scene.hpp"
#include "run/support.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/io/inspect.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

TEST_SUITE("app/options") {
  TEST_CASE("every option of synth reaches the scene: the files are those that the library writes") {
    const TempFolder temp;
    const SynthOptions plain{.frames = 10, .size = 12};
    struct Row {
      std::vector<std::string> words;
      std::function<void(SynthOptions&)> set;
    };
    const auto film = [](SynthOptions& o) {
      o.orbit = 0.5;
      o.film = true;
    };
    const auto rig = [](SynthOptions& o) -> SynthRig& {
      o.rig.cameras = 3;
      return o.rig;
    };
    const std::vector<Row> rows{
        {{}, [](SynthOptions&) {}},
        {{"--seed", "5"}, [](SynthOptions& o) { o.seed = 5; }},
        {{"--gloss", "0.9"}, [](SynthOptions& o) { o.look.gloss = 0.9; }},
        {{"--fade", "0.5"}, [](SynthOptions& o) { o.look.fade = 0.5; }},
        {{"--light", "0.3"}, [](SynthOptions& o) { o.look.light = 0.3; }},
        {{"--repeats", "3"}, [](SynthOptions& o) { o.look.repeats = 3; }},
        {{"--opaque"}, [](SynthOptions& o) { o.look.opaque = true; }},
        {{"--room"}, [](SynthOptions& o) { o.look.room = true; }},
        {{"--orbit", "0.5", "--film"}, film},
        {{"--orbit", "0.5", "--film", "--drift", "0.4"},
         [&](SynthOptions& o) {
           film(o);
           o.drift = 0.4;
         }},
        {{"--orbit", "0.5", "--film", "--shake", "0.1"},
         [&](SynthOptions& o) {
           film(o);
           o.shake = 0.1;
         }},
        {{"--cameras", "3", "--arc", "0.3"}, [&](SynthOptions& o) { rig(o).arc = 0.3; }},
        {{"--cameras", "3", "--turns"}, [&](SynthOptions& o) { rig(o).turns = true; }},
        {{"--cameras", "3", "--exposures", "0.4"}, [&](SynthOptions& o) { rig(o).exposures = 0.4; }},
        {{"--cameras", "3", "--offsets", "1.5"}, [&](SynthOptions& o) { rig(o).late = 1.5; }},
        {{"--cameras", "3", "--masks"}, [&](SynthOptions& o) { rig(o).masks = true; }},
        {{"--cameras", "3", "--masks", "--movers"},
         [&](SynthOptions& o) { rig(o).masks = rig(o).movers = true; }},
        {{"--tracks"}, [](SynthOptions& o) { o.tracks = true; }},
        {{"--depth", "inverse"}, [](SynthOptions& o) { o.depth = DepthKind::inverse; }},
    };
    std::map<std::string, std::string> of_plain;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Row& row = rows[i];
      const std::string made = temp.str() + "/made" + std::to_string(i), wanted = made + "_wanted";
      std::vector<std::string> words{"synth", "toy", "--out", made, "--frames", "10", "--size", "12"};
      words.insert(words.end(), row.words.begin(), row.words.end());
      const Ended e = program(words);
      CAPTURE(fmt::format("{}", fmt::join(row.words, " ")));
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      SynthOptions options = plain;
      row.set(options);
      write_synth("toy", wanted, options);
      const auto files = files_of(made);
      CHECK(files == files_of(wanted));
      if (i == 0) of_plain = files;
      CHECK((files == of_plain) == (i == 0));
    }
  }

  TEST_CASE("an orbit is as high as it is told, a page's views as large, and numbers as exact") {
    const BallScene scene;  // with pictures of 24 pixels
    REQUIRE(program(train_small(scene.data, scene.path("run"), {"--max-steps", "4"})).code == 0);
    for (const int degrees : {-30, 20, 70}) {
      const std::string out = scene.path("cameras" + std::to_string(degrees));
      const Ended e =
          program({"render", scene.path("run"), "--camera", "orbit", "--elevation", std::to_string(degrees),
                   "--times", "0:1:3", "--format", "cameras", "--out", out});
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      const Json frames = Json::parse(slurp(out + "/cameras.json"))["frames"];
      REQUIRE(frames.size() == 3);
      for (const Json& frame : frames) {  // the camera looks along its -z axis, at what it goes round
        const double up = frame["transform_matrix"][2][2];
        CHECK(std::asin(up) * 180 / 3.14159265358979 == doctest::Approx(degrees).epsilon(1e-6));
      }
    }
    for (const int size : {16, 24}) {
      const std::string page = scene.path("page.html");
      const Ended e = program({"view", scene.path("run"), "--out", page, "--views", "1", "--split", "train",
                               "--view-size", std::to_string(size)});
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      const Json header = Json::parse(between(slurp(page), "id=\"header\">", "</script>"));
      CHECK(header["views"][0]["camera"]["width"] == (size < 24 ? 12 : 24));  // by whole pixels
    }

    for (const bool full : {false, true}) {
      const std::string frames = scene.path(full ? "full" : "half");
      std::vector<std::string> words{"export", scene.path("run"), "--out", frames, "--frames", "1"};
      if (full) words.push_back("--full");
      REQUIRE(program(words).code == 0);
      int grids = 0;
      for (const auto& file : fs::directory_iterator(frames))
        if (file.path().extension() == ".vdb")
          for (const GridInfo& grid : inspect_vdb(file.path().string()).grids) {
            CHECK(grid.half == !full);
            ++grids;
          }
      CHECK(grids > 0);
    }
  }

  TEST_CASE("eval measures motion and densities where a data set has their truth") {
    const TempFolder temp;
    for (const char* scene : {"toy", "smoke"}) {
      CAPTURE(scene);
      const bool gas = scene == std::string("smoke");
      const std::string data = temp.str() + "/" + scene, run = data + "_run";
      REQUIRE(program({"synth", scene, "--out", data, "--frames", "10", "--size", "48"}).code == 0);
      REQUIRE(program(train_small(data, run, {"--max-steps", "40"})).code == 0);
      std::vector<std::string> words{"eval", run, "--json"};
      if (gas)
        words.insert(words.end(), {"--truth-volume", data + "/truth_volume"});
      else
        words.push_back("--truth");
      const Ended e = program(words);
      CAPTURE(e.err);
      REQUIRE(e.code == 0);
      const Json figures = Json::parse(e.out);
      if (gas) {
        CHECK(figures["truth_volume"]["moments"].size() == 10);
        CHECK(figures["truth_volume"]["scale"] > 0);
      } else {
        CHECK(figures["truth"]["correspondence"]["pairs"] > 0);
        CHECK(std::isfinite(figures["truth"]["track"]["median"].get<double>()));
      }
    }
  }
}
