// SPDX-License-Identifier: Apache-2.0
// Budgets by the clock: what was done with them is said, and a run goes on with a larger one.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "ball_scene.hpp"
#include "run/progress.hpp"
#include "splinevox/train/config.hpp"

using namespace splinevox;
using namespace splinevox::test;
using Json = nlohmann::json;

TEST_SUITE("app/work") {
  TEST_CASE("the time left is told by steps alone, once there are enough of them") {
    const auto report = [](double seconds, double progress) {
      StepReport r;
      r.seconds = seconds;
      r.progress = progress;
      return r;
    };
    const StepReport first = report(140, 0.001);  // after trials
    CHECK(run::time_left(first, first).empty());
    CHECK(run::time_left(first, report(140.5, 0.006)).empty());
    CHECK(run::time_left(first, report(144, 0.401)) == "6.0 s left");
    CHECK(run::time_left(report(30, 0.5), report(40, 0.75)) == "0:10 left");
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
                                     "--set",      "grid.radiance_start=0,0.3"};
      words.insert(words.end(), more.begin(), more.end());
      return program(words);
    };
    Ended e = train("1", {"--preset", "fast"});
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    const Json first = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    const int usual = first["preset_steps"];
    CHECK(first["preset_share"].get<double>() == doctest::Approx(first["steps"].get<double>() / usual));
    REQUIRE(first["preset_share"] < 0.25);
    CHECK(contains(e.out + e.err, "that preset fast was measured with; go on with --resume --max-time "));
    const Json manifest = Json::parse(slurp(scene.path("run") + "/manifest.json"));
    CHECK(manifest["info"]["steps"] == std::to_string(first["steps"].get<int>()));
    CHECK(manifest["info"]["preset_steps"] == std::to_string(usual));
    const Json effects = Json::parse(slurp(scene.path("run") + "/effects.json"));
    CHECK(contains(effects["note"], "too short a run to try effects out"));

    const Ended again = train("1", {"--resume"});
    CHECK(contains(again.out + again.err, "there is nothing to go on with"));
    CHECK(train("0.5", {"--resume"}).code == 2);  // less than it had
    e = train("2", {"--resume", "--json"});
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
    CHECK(contains(e.out, "was measured with"));
    const Json second = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    CHECK(second["steps"] > first["steps"]);
    CHECK(second["finished"] == true);
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "max_time = 2"));
    CHECK(program({"verify", scene.path("run")}).code == 0);
  }
}
