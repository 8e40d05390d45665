// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "app/ball_scene.hpp"
#include "cli/tree.hpp"

using namespace splinevox::test;
using Json = nlohmann::json;

namespace {

/// The lines of standard output, every one of which has to be an event.
std::vector<Json> events_of(const std::vector<std::string>& words, int code = 0) {
  std::vector<std::string> asked = words;
  asked.push_back("--json");
  const Ended ended = program(asked);
  CAPTURE(words.front());
  CAPTURE(ended.out);
  CAPTURE(ended.err);
  CHECK(ended.code == code);
  std::vector<Json> events;
  std::istringstream in(ended.out);
  for (std::string line; std::getline(in, line);) {
    REQUIRE(Json::accept(line));
    const Json& event = events.emplace_back(Json::parse(line));
    for (const char* key : {"event", "timestamp", "run_id", "verb"}) {
      CAPTURE(key);
      REQUIRE(event.contains(key));
      CHECK(event[key].is_string());
    }
    CHECK(event["verb"] == words.front());
    CHECK(event["run_id"] == events.front()["run_id"]);
    CHECK(event["timestamp"].get<std::string>().size() == std::string("2026-01-02T03:04:05.678Z").size());
  }
  REQUIRE_FALSE(events.empty());
  CHECK(events.back()["event"] == (code == 0 ? "result" : "error"));
  for (std::size_t i = 0; i + 1 < events.size(); ++i) CHECK(events[i]["event"] != "result");
  return events;
}

const Json* first(const std::vector<Json>& events, const std::string& name) {
  for (const Json& e : events)
    if (e["event"] == name) return &e;
  return nullptr;
}

}  // namespace

TEST_SUITE("cli/json") {
  TEST_CASE("with --json every verb prints events alone, and the last one is the result") {
    const TempFolder folder;
    const auto path = [&](const std::string& name) { return folder.str() + "/" + name; };
    const std::string scene = path("scene"), run = path("run"), splats = path("splats");
    std::set<std::string> done;
    const auto events = [&](const std::vector<std::string>& words) {
      done.insert(words.front());
      return events_of(words);
    };
    CHECK(events({"synth", "dancer", "--out", scene, "--frames", "6", "--size", "16"}).back()["out"] ==
          scene);
    CHECK(events({"convert", scene, "--out", path("copy")}).back()["pictures"] > 6);
    CHECK(events({"info", scene}).back().contains("splits"));
    const std::vector<Json> trained = events(
        {"train", scene, "--out", run, "--preset", "draft", "--max-steps", "8", "--set", "sampling.rays=128",
         "--set", "grid.radiance=8,12,16", "--set", "motion.points=4", "--set", "effects.steps=0"});
    CHECK(trained.back()["steps"] == 8);
    CHECK(events({"train", "--list-settings"}).back()["settings"].is_string());
    REQUIRE(first(trained, "effects"));
    CHECK(first(trained, "effects")->contains("used"));
    REQUIRE(first(trained, "note"));
    CHECK(first(trained, "note")->at("note").is_string());
    REQUIRE(first(trained, "progress"));
    CHECK(first(trained, "progress")->contains("loss"));
    CHECK(events({"eval", run}).back()["split"] == "test");
    CHECK(events({"verify", run}).back()["bad"] == 0);
    const std::vector<Json> exported =
        events({"export", run, "--out", splats, "--profile", "splats", "--frames", "1-2"});
    REQUIRE(first(exported, "frame"));
    CHECK(first(exported, "frame")->at("frame") == 1);
    CHECK(exported.back()["frames"] == 2);
    CHECK(events({"import", splats, "--out", path("vdb"), "--voxel-size", "0.1"}).back()["frames"] == 2);
    const std::vector<Json> rendered = events(
        {"render", run, "--out", path("film"), "--camera", "orbit", "--times", "0:1:2", "--size", "16"});
    CHECK(rendered.back()["pictures"] == 2);
    CHECK(first(rendered, "progress")->at("total") == 2);
    CHECK(events({"view", run, "--out", path("page.html")}).back()["bytes"] > 1000);
    CHECK(events({"report", run, "--out", path("report.html")}).back()["bytes"] > 1000);
    CHECK(events({"edit", run, "--out", path("slow"), "--reverse"}).back()["operations"].size() == 1);
    write_text(path("points.csv"), "x,y,z\n0,0,0\n");
    CHECK(events({"track", run, "--points", path("points.csv"), "--to", "1", "--out", path("to.csv")})
              .back()["points"] == 1);
    write_text(path("sweep.toml"),
               "datasets = [\"" + scene +
                   "\"]\npresets = [\"draft\"]\nseeds = [1]\ntrain = [\"--max-steps\", \"4\", "
                   "\"--effects\", \"all\", \"--set\", \"sampling.rays=128\", \"--set\", "
                   "\"grid.radiance=8,12,16\", \"--set\", \"motion.points=4\"]\n");
    const std::vector<Json> swept = events({"sweep", path("sweep.toml"), "--out", path("sweep")});
    REQUIRE(first(swept, "task"));
    CHECK(first(swept, "task")->at("ended") == 1);
    CHECK(swept.back()["failed"].empty());

    CLI::App app;
    for (const auto& [verb, action] : splinevox::cli::declare_verbs(app)) {
      const std::string name = verb->get_name();
      const bool program_text = name == "man" || name == "completion";  // their text is for other programs
      const bool needs_colmap = name == "capture";
      CHECK_MESSAGE((done.contains(name) || program_text || needs_colmap), name);
      CHECK((verb->get_option_no_throw("--json") != nullptr) == !program_text);
    }
  }

  TEST_CASE("an error is a message for people, an event for programs, and the same exit code") {
    const TempFolder folder;
    const std::vector<std::vector<std::string>> wrong = {
        {"eval", folder.str() + "/nothing"},
        {"capture", folder.str() + "/nothing.mp4", "--out", folder.str() + "/scene"},
        {"eval", folder.str(), "--no-such-option"},
        {"trian", folder.str()},
        {"train", folder.str(), "--out", folder.str() + "/run", "--set", "sampling.rays=-1"}};
    for (const std::vector<std::string>& words : wrong) {
      const Ended plain = program(words);
      CHECK(plain.code == 2);
      CHECK(plain.out == "");
      const Json error = events_of(words, 2).back();
      for (const char* key : {"where", "what", "expected", "found", "try"}) {
        CAPTURE(key);
        CHECK(error[key].is_string());
      }
      CHECK(error["exit_code"] == 2);
      CHECK(error["fault"] == "input");
      CHECK(contains(plain.err, error["what"].get<std::string>()));
      CHECK(contains(plain.err, error["try"].get<std::string>().substr(0, 8)));
    }
  }

  TEST_CASE("a run id that a pipeline gives is in every line") {
    const TempFolder folder;
    ::setenv("SPLINEVOX_RUN_ID", "shot 7", 1);
    const std::vector<Json> events = events_of({"verify", folder.str()}, 2);
    ::unsetenv("SPLINEVOX_RUN_ID");
    CHECK(events.front()["run_id"] == "shot 7");
    CHECK(events_of({"verify", folder.str()}, 2).front()["run_id"] != "shot 7");
  }
}
