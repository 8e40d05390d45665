// SPDX-License-Identifier: Apache-2.0
#include "run/own_json.hpp"

#include <doctest/doctest.h>

#include "app/ball_scene.hpp"
#include "run/sweep/sweep.hpp"
#include "splinevox/core/error.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

namespace {

std::string message_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const Error& e) {
    CHECK(e.fault == Fault::input);
    return e.what();
  }
  return "";
}

const std::string kDeep = std::string(200'000, '[') + std::string(200'000, ']');

}  // namespace

TEST_SUITE("app/own_json") {
  TEST_CASE("a field of a wrong type is named with its file") {
    const TempFolder folder;
    const std::string path = folder.str() + "/m.json";
    struct Row {
      std::string text, named;
      void (*read)(const std::string&);
    };
    const auto metrics = [](const std::string& p) { read_metrics(p); };
    const auto effects = [](const std::string& p) { read_effects_if_there(p); };
    const auto history = [](const std::string& p) { read_history_if_there(p); };
    for (const Row& row : std::vector<Row>{
             {"[]", "not what it should hold", metrics},
             {R"({"steps": "many"})", "the field steps", metrics},
             {R"({"finished": 1})", "the field finished", metrics},
             {R"({"phases": {"march": {}}})", "phases.march", metrics},
             {R"({"frames": [{"psnr": 1}, 3]})", "frames[]", metrics},
             {R"({"frames": [{"name": 3}]})", "frames[].name", metrics},
             {R"({"stride": [2]})", "the field stride", metrics},
             {R"({"cameras": [{"gain": [null, 1, 1]}]})", "cameras[].gain[] was not finite", metrics},
             {R"({"effects": {}})", "the field effects", effects},
             {R"({"effects": [{"effect": 4}]})", "effects[].effect", effects},
             {R"({"effects": [{"where": "x"}]})", "effects[].where", effects},
             {R"({"effects": [{"apart": "x"}]})", "effects[].apart", effects},
             {R"({"film": {"psnr": "x"}})", "film.psnr", effects},
             {R"({"still_cameras": {"cameras": [1]}})", "still_cameras.cameras", effects},
             {R"({"history": 7})", "the field history", history},
             {R"({"history": [[1]]})", "history[]", history},
             {R"({"history": [{"operations": [{"value": 2}]}]})", "history[].operations[].value", history},
             {kDeep, "nested too deeply", metrics},
             {kDeep, "nested too deeply", history}}) {
      CAPTURE(row.named);
      write_text(path, row.text);
      const std::string message = message_of([&] { row.read(path); });
      CHECK(message.find(path) == 0);
      CHECK(contains(message, row.named));
    }
  }

  TEST_CASE("what is right is read; a number that was not finite is not there") {
    const TempFolder folder;
    const std::string path = folder.str() + "/m.json";
    CHECK(read_metrics_if_there(path) == Json::object());
    CHECK(read_history_if_there(path) == Json::array());
    CHECK(read_effects_if_there(path).is_null());
    write_text(path,
               R"({"psnr": null, "steps": 7, "other": [[{}]], "frames": [{"psnr": null, "time": 0.5}]})");
    CHECK(read_metrics(path).dump() == R"({"steps":7,"other":[[{}]],"frames":[{"time":0.5}]})");
    write_text(path, R"({"history": [{"from": "a"}]})");
    CHECK(read_history_if_there(path).size() == 1);
  }

  TEST_CASE("lines: a torn one is left out, one nested too deeply or of wrong types is named by its number") {
    const TempFolder folder;
    const std::string path = folder.str() + "/metrics.jsonl";
    write_text(path, "{\"step\": 1}\n{\"step\": 2, \"lo\n{\"step\": 3}\n{\"st");
    const std::vector<MetricsLine> lines = read_metrics_lines(path);
    REQUIRE(lines.size() == 2);
    CHECK(lines[1].text == "{\"step\": 3}");
    CHECK(lines[1].json["step"] == 3);
    write_text(path, "{\"step\": 1}\n" + kDeep + "\n");
    CHECK(contains(message_of([&] { read_metrics_lines(path); }), "line 2: the JSON is nested too deeply"));
    write_text(path, "{\"step\": 1}\n{\"held_psnr\": \"x\"}\n");
    CHECK(contains(message_of([&] { read_metrics_lines(path); }), "line 2: the field held_psnr"));
  }

  TEST_CASE("one bad run does not stop a sweep") {
    const TempFolder folder;
    const std::string description =
        describe_sweep(folder,
                       "seeds = [1, 7]\ntrain = [\"--max-steps\", \"4\", "
                       "\"--set\", \"effects.steps=0\", \"--set\", \"sampling.rays=128\", \"--set\", "
                       "\"grid.radiance=8,12,16\", \"--set\", \"motion.points=4\"]\n"
                       "[settings]\nplain = []\n");
    const std::string out = folder.str() + "/out", bad = out + "/ball_draft_plain_s1/metrics.json";
    write_text(bad, kDeep);
    const std::vector<std::string> words = {"sweep", description, "--out", out};
    const Ended e = program(words);
    CHECK(e.code == 1);
    CHECK(contains(e.out, "ball_draft_plain_s1: failed: "));
    CHECK(contains(e.out, "nested too deeply"));
    CHECK(contains(e.out, "ball_draft_plain_s7: PSNR"));
    CHECK(std::filesystem::exists(out + "/ball_draft_plain_s7/model.vdb"));
    CHECK(contains(slurp(out + "/table.csv"), "ball_draft_plain_s7"));
  }
}
