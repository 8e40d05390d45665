// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <csignal>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;
using Scene = BallScene;

TEST_SUITE("app/resume") {
  TEST_CASE("a run is not overwritten, and is resumed only with its own configuration and data") {
    const Scene scene;
    const Ended fresh = program(scene.train("run", "20", {"--resume", "--quiet"}));
    CAPTURE(fresh.err);
    REQUIRE(fresh.code == 0);
    const std::string model = slurp(scene.path("run") + "/model.vdb");
    const Ended again = program(scene.train("run", "20"));
    CHECK(again.code == 2);
    CHECK(contains(again.err, "already holds a run"));
    CHECK(contains(again.err, "--resume"));
    const Ended changed = program(scene.train("run", "20", {"--resume", "--set", "loss.offset=1"}));
    CHECK(changed.code == 2);
    CHECK(contains(changed.err, "offset = 1"));
    const Ended preset =
        program({"train", scene.data, "--out", scene.path("run"), "--resume", "--preset", "paper"});
    CHECK(preset.code == 2);
    CHECK(contains(preset.err, "was made with another preset"));
    write_moving_ball(scene.path("other"), {9, 2, 3, 24, 0.8});
    const Ended other = program({"train", scene.path("other"), "--out", scene.path("run"), "--resume"});
    CHECK(other.code == 2);
    CHECK(contains(other.err, "other training data"));
    REQUIRE(program({"eval", scene.path("run")}).code == 0);
    const std::string metrics = slurp(scene.path("run") + "/metrics.json");
    // Finished is finished, with a checkpoint and without: neither the model nor what eval found is made
    // anew.
    for (const bool gone : {false, true}) {
      if (gone) fs::remove(scene.path("run") + "/checkpoint.bin");
      const Ended same = program({"train", scene.data, "--out", scene.path("run"), "--resume"});
      CAPTURE(same.err);
      CHECK(same.code == 0);
      CHECK(contains(same.err, "is finished"));
      CHECK(slurp(scene.path("run") + "/model.vdb") == model);
      CHECK(slurp(scene.path("run") + "/metrics.json") == metrics);
      CHECK(program({"train", scene.path("other"), "--out", scene.path("run"), "--resume"}).code == 2);
    }
  }

  TEST_CASE("the words that began a run resume it, also where effects and the box were settled otherwise") {
    const Scene scene;
    const std::vector<std::string> words =
        scene.train("run", "20", {"--quiet", "--set", "run.background_order=2", "--resume"});
    REQUIRE(program(words).code == 0);  // pictures with alpha have no background to learn
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "background_order = -1"));
    CHECK(contains(slurp(scene.path("run") + "/asked.toml"), "background_order = 2"));
    CHECK(program({"verify", scene.path("run")}).code == 0);
    const Ended again = program(words);
    CAPTURE(again.err);
    CHECK(again.code == 0);
    CHECK(
        program(scene.train("run", "20", {"--quiet", "--set", "run.background_order=1", "--resume"})).code ==
        2);
  }

  TEST_CASE("a run goes on with a data set that has moved, and knows where it is then") {
    const Scene scene;
    const auto trained = [&](const std::string& data) {
      fs::remove(scene.path("run") + "/metrics.json");  // as if it had been killed behind its last checkpoint
      std::vector<std::string> words = scene.train("run", "10", {"--quiet", "--resume"});
      words[1] = data;
      const Ended e = program(words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
    };
    const auto measured = [&] { return program({"eval", scene.path("run")}).code == 0; };
    trained(scene.data + "/");
    CHECK(measured());
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "dataset = \"" + scene.data + "\""));
    fs::rename(scene.data, scene.path("moved"));
    CHECK_FALSE(measured());
    trained(scene.path("moved"));
    CHECK(measured());
    REQUIRE(program({"view", scene.path("run"), "--out", scene.path("page.html")}).code == 0);
    CHECK(contains(slurp(scene.path("page.html")), ">moved, preset draft"));
    CHECK(program({"report", scene.path("run"), "--out", scene.path("page.html")}).code == 2);
    CHECK(program({"report", scene.path("run"), "--out", scene.path("report.html")}).code == 0);
    const std::string report = slurp(scene.path("report.html"));
    CHECK(program({"view", scene.path("run"), "--out", scene.path("report.html")}).code == 2);
    CHECK(slurp(scene.path("report.html")) == report);
    // Steps that were discarded have no time, and a chart none of them.
    const std::string lines = scene.path("run") + "/metrics.jsonl";
    write_text(lines, "{\"step\": 1, \"discarded\": true}\n" + slurp(lines));
    CHECK(program({"report", scene.path("run"), "--out", scene.path("report.html")}).code == 0);
    CHECK(slurp(scene.path("report.html")) == report);
  }

  TEST_CASE("verify says of a run that has not ended that it has not") {
    const Scene scene;
    REQUIRE(program(scene.train("run", "5", {"--quiet"})).code == 0);
    fs::remove(scene.path("run") + "/manifest.json");
    const Ended e = program({"verify", scene.path("run")});
    CHECK(e.code == 2);
    CHECK(contains(e.err, "--resume goes on"));
  }

  TEST_CASE("--resume without a checkpoint starts afresh with the run's own settings, and says so") {
    const Scene scene;
    const std::string afresh = "there is no checkpoint in " + scene.path("run") + ": starting afresh";
    const Ended e = program(scene.train("run", "5", {"--resume"}));
    CHECK(e.code == 0);
    CHECK(contains(e.err, afresh));
    // As if it had been killed before its first checkpoint.
    for (const char* name : {"checkpoint.bin", "model.vdb", "metrics.json", "manifest.json"})
      fs::remove(scene.path("run") + "/" + name);
    const Ended again = program({"train", scene.data, "--out", scene.path("run"), "--resume", "--json"});
    CAPTURE(again.err);
    CHECK(again.code == 0);
    CHECK(contains(again.out, afresh));
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "preset = \"draft\""));
    CHECK(Json::parse(slurp(scene.path("run") + "/metrics.json"))["steps"] == 5);
  }

  TEST_CASE("interrupted and resumed ends in the same bits as never interrupted") {
    const Scene scene;
    REQUIRE(program(scene.train("whole", "500", {"--quiet", "--threads", "2"})).code == 0);
    std::vector<std::string> words = scene.train("parts", "500", {"--quiet", "--threads", "1"});
    words.insert(words.begin(), SPLINEVOX_PROGRAM);
    Started started(words);
    REQUIRE(comes([&] { return !slurp(scene.path("parts") + "/metrics.jsonl").empty(); }));
    ::kill(started.process(), SIGINT);
    const Ended stopped = started.wait();
    CAPTURE(stopped.err);
    CHECK(stopped.code == 130);
    CHECK(fs::exists(scene.path("parts") + "/model.vdb"));
    CHECK(Json::parse(slurp(scene.path("parts") + "/metrics.json"))["finished"] == false);
    CHECK(Json::parse(slurp(scene.path("parts") + "/metrics.json"))["ended"] == "signal");
    const Ended resumed =
        program({"train", scene.data, "--out", scene.path("parts"), "--resume", "--json", "--threads", "3"});
    CAPTURE(resumed.err);
    REQUIRE(resumed.code == 0);
    CHECK(slurp(scene.path("parts") + "/model.vdb") == slurp(scene.path("whole") + "/model.vdb"));
    CHECK(Json::parse(slurp(scene.path("parts") + "/metrics.json"))["ended"] == "steps");
    std::stringstream lines(resumed.out);
    for (std::string line; std::getline(lines, line);) CHECK(Json::accept(line));
  }

  TEST_CASE("a disk that fills up is an error, and nothing already saved is lost") {
    const Scene scene;
    REQUIRE(program(scene.train("run", "5", {"--quiet"})).code == 0);
    const std::string model = slurp(scene.path("run") + "/model.vdb");
    std::string metrics = slurp(scene.path("run") + "/metrics.json");
    metrics.replace(metrics.find("true", metrics.find("\"finished\"")), 4,
                    "false");  // a run that is finished would be left alone
    write_text(scene.path("run") + "/metrics.json", metrics);
    const std::string command = "ulimit -f 16; exec '" + std::string(SPLINEVOX_PROGRAM) + "' train '" +
                                scene.data + "' --out '" + scene.path("run") + "' --resume --quiet";
    const Ended e = Started({"sh", "-c", command}).wait();
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, scene.path("run")));
    CHECK(slurp(scene.path("run") + "/model.vdb") == model);
    CHECK(slurp(scene.path("run") + "/metrics.json") == metrics);
    CHECK(program({"eval", scene.path("run")}).code == 0);
  }
}
