// SPDX-License-Identifier: Apache-2.0
// Budgets by the clock: what was done with them is said, and a run goes on with a larger one.
#include <doctest/doctest.h>

#include <algorithm>

#include "ball_scene.hpp"
#include "run/progress.hpp"
#include "run/support.hpp"
#include "splinevox/train/config.hpp"

using namespace splinevox;
using namespace splinevox::test;
using run::Json;

namespace {

StepReport report(double seconds, double progress) {
  StepReport r;
  r.seconds = seconds;
  r.progress = progress;
  return r;
}

}  // namespace

TEST_SUITE("app/work") {
  TEST_CASE("the time left is told by steps alone, once there are enough of them") {
    run::Pace even;
    CHECK_FALSE(even.left());
    even.add(report(140, 0.001));  // after trials
    CHECK_FALSE(even.left());
    even.add(report(140.5, 0.006));
    CHECK_FALSE(even.left());
    even.add(report(144, 0.401));
    CHECK(*even.left() == doctest::Approx(3.5 * 0.599 / 0.395));
  }

  TEST_CASE("the time left of a run that counts steps knows that rays grow and lattices get finer") {
    Config config = preset("fast");
    config.run.max_time = 0;
    config.run.max_steps = 1000;
    config.grid.radiance = {40, 120};
    config.grid.radiance_start = {0, 0.5f};
    config.sampling.growth = 1;
    run::Pace stages(config);
    for (int i = 0; i <= 40; ++i) stages.add(report(100 + i, 0.01 * i));
    CHECK(*stages.left() == doctest::Approx(10 + 50 * 2));  // the finer lattice costs twice as much
    config.grid.radiance = {40};
    config.grid.radiance_start = {0};
    config.sampling.growth = 3;
    run::Pace rays(config);
    for (int i = 0; i <= 50; ++i) rays.add(report(0.01 * i + 1e-4 * i * i, 0.01 * i));
    CHECK_FALSE(rays.left());  // 0.75 s
    run::Pace slower(config);
    for (int i = 0; i <= 50; ++i) slower.add(report(100 * (0.01 * i + 1e-4 * i * i), 0.01 * i));
    CHECK(*slower.left() == doctest::Approx(200 - 75));
  }

  TEST_CASE("the time left of a run by the clock is what is left of its seconds") {
    run::Pace pace(preset("fast"));  // 60 seconds
    pace.add(report(15, 0.25));
    CHECK(*pace.left() == doctest::Approx(45));
    pace.add(report(15, 0.125));  // twice the time
    CHECK(*pace.left() == doctest::Approx(105));
  }

  TEST_CASE("the progress line fits the terminal, and says how long it takes at any width") {
    run::LineParts parts{0.42,        "step    554", "loss 7.43e-03", "PSNR 31.8 held-out",
                         "26.1 rays", "719 krays/s", "0:30 left"};
    std::size_t longest = 0;
    for (const int width : {20, 30, 40, 60, 80, 81, 100, 120, 200}) {
      CAPTURE(width);
      const std::string line = run::bar_line(parts, width);
      const auto columns =
          std::count_if(line.begin(), line.end(), [](char c) { return (std::uint8_t(c) & 0xc0) != 0x80; });
      CHECK(columns < width);
      CHECK(contains(line, " 42%"));
      if (width >= 30) CHECK(contains(line, "0:30 left"));
      longest = std::max(longest, std::size_t(columns));
    }
    CHECK(longest > 100);
    CHECK(contains(run::bar_line(parts, 120), "loss"));
    CHECK_FALSE(contains(run::bar_line(parts, 80), "loss"));
    CHECK(contains(run::bar_line(parts, 80), "31.8 held-out, 26.1 rays"));
  }

  TEST_CASE("a run that is not named gets a new folder each time, and says which") {
    const BallScene scene;
    const std::vector<std::string> words = {
        "train", scene.data,       "--preset",          "draft", "--max-steps",
        "2",     "--set",          "sampling.rays=128", "--set", "grid.radiance=8,12,16",
        "--set", "motion.points=4"};
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(scene.temp.str());
    const Ended one = program(words), two = program(words);
    const Ended resumed = program({"train", scene.data, "--resume"});
    std::filesystem::current_path(before);
    CHECK(one.code == 0);
    CHECK(two.code == 0);
    std::vector<std::string> runs;
    for (const auto& entry : std::filesystem::directory_iterator(scene.path("runs"))) {
      runs.push_back("runs/" + entry.path().filename().string());
      CHECK(std::filesystem::exists(entry.path() / "model.vdb"));
      CHECK(runs.back().starts_with("runs/ball-20"));
      CHECK(contains(one.err + two.err, "run: " + runs.back() + "\n"));
    }
    CHECK(runs.size() == 2);
    CHECK(resumed.code == 2);
    CHECK(contains(resumed.err, "--out is missing"));
  }

  TEST_CASE("seconds that loading used up are said before a model is made") {
    const BallScene scene;
    const Ended e = program({"train", scene.data, "--out", scene.path("none"), "--max-time", "0.001"});
    CAPTURE(e.err);
    CHECK(e.code == 2);
    CHECK(contains(e.err, "none are left to train"));
    CHECK(contains(e.err, "--max-time "));
    CHECK_FALSE(std::filesystem::exists(scene.path("none")));
  }

  TEST_CASE("few steps for the preset are said, in JSON too; the run goes on with more time") {
    const BallScene scene;
    const auto train = [&](const std::string& seconds, const std::vector<std::string>& more) {
      std::vector<std::string> words{"train",      scene.data,
                                     "--out",      scene.path("run"),
                                     "--max-time", seconds,
                                     "--threads",  "1",
                                     "--set",      "sampling.rays=512",
                                     "--set",      "grid.radiance=16,24",
                                     "--set",      "grid.radiance_start=0,0.3",
                                     "--set",      "grid.motion=4,8",
                                     "--set",      "grid.motion_start=0,0.2"};
      words.insert(words.end(), more.begin(), more.end());
      return program(words);
    };
    Ended e = train("1", {"--preset", "high"});
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    const Json first = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    const int usual = first["preset_steps"];
    CHECK(first["preset_share"].get<double>() == doctest::Approx(first["steps"].get<double>() / usual));
    REQUIRE(first["preset_share"] < 0.25);
    CHECK(contains(e.out + e.err, "that preset high was measured with; go on with --resume --max-time "));
    const Json manifest = Json::parse(slurp(scene.path("run") + "/manifest.json"));
    CHECK(manifest["info"]["steps"] == std::to_string(first["steps"].get<int>()));
    CHECK(manifest["info"]["preset_steps"] == std::to_string(usual));
    const Json effects = Json::parse(slurp(scene.path("run") + "/effects.json"));
    CHECK(contains(effects["note"], "too short a run to try effects out"));

    const Ended again = train("1", {"--resume"});
    CHECK(contains(again.out + again.err, "there is nothing to go on with"));
    CHECK(train("0.5", {"--resume"}).code == 2);  // less than it had
    e = train("6", {"--resume", "--json"});       // a second more held no step on a loaded machine
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    CHECK(contains(e.out, "was measured with"));
    const Json second = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    CHECK(second["steps"] > first["steps"]);
    CHECK(second["finished"] == true);
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "max_time = 6"));
    CHECK(program({"verify", scene.path("run")}).code == 0);
  }
}
