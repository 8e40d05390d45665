// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>

#include "curves.hpp"
#include "present.hpp"
#include "support/tiny_dataset.hpp"
#include "timing.hpp"

using namespace splinevox::cost;

namespace {

Record point(const char* knob, const char* value, double seconds, double error) {
  Record r;
  r.suite = "render";
  r.scene = "dancer";
  r.knob = knob;
  r.value = value;
  r.seconds = {seconds, 0.98 * seconds, 1.02 * seconds};
  r.error = {error, error, error};
  r.is_default = r.knob == "default";
  r.runs = 5;
  return r;
}

}  // namespace

TEST_SUITE("bench/cost") {
  const std::vector<Record> records{point("default", "as it is", 1, 0.01), point("A/A", "again", 1.03, 0.01),
                                    point("step", "half", 2, 0.0025), point("step", "double", 0.5, 0.04),
                                    point("skipping", "off", 3, 0.01)};
  TEST_CASE("the front has what nothing beats, by time; a failure is never on it") {
    CHECK(pareto_front(records) == std::vector<std::size_t>{3, 0, 2});
    CHECK(distance_to_front(records, records[4]) == doctest::Approx(3));
    CHECK(distance_to_front(records, records[2]) == 1);
    std::vector<Record> more = records;
    more.push_back(point("broken", "", 0.1, 0.001));
    more.back().failed = true;
    CHECK(pareto_front(more) == pareto_front(records));
    more.back().failed = false;
    more.back().scene = "another";
    CHECK(distance_to_front(more, records[0]) == 1);
  }
  TEST_CASE("a line comes back as it was written") {
    Record r = point("step", "half", 2, 0.0025);
    r.quality = 31.5;
    r.samples = 12;
    r.instructions = 1e9;
    r.expected_dominated = true;
    r.note = "a \"note\"";
    CHECK(to_json(from_json(to_json(r))) == to_json(r));
    CHECK_THROWS(from_json(Json::parse("{\"suite\": \"train\"}")));
  }
  TEST_CASE(
      "a setting that failed stays: as a line, in the table, as a cross in the diagram, and never on the "
      "front") {
    Record r = point("step", "four times", 0.25, NAN);
    r.failed = true;
    r.note = "no < picture";
    r.quality = NAN;
    r.where = "here";
    const Record back = from_json(Json::parse(to_json(r).dump()));
    CHECK(std::isnan(back.error.value));
    CHECK(std::isnan(back.quality));
    CHECK(back.note == r.note);
    CHECK(back.where == "here");
    std::vector<Record> more = records;
    more.push_back(back);
    CHECK(pareto_front(more) == pareto_front(records));
    CHECK(table(more).find("step (failed) | four times") != std::string::npos);
    CHECK(sentences(more) == sentences(records));
    const std::string svg = diagram(more, "");
    CHECK(svg.find("failed: no &lt; picture") != std::string::npos);
    CHECK(svg.find("nan") == std::string::npos);
  }
  TEST_CASE("tables, sentences and diagrams are made from the lines") {
    const std::string rows = table(records), text = sentences(records), svg = diagram(records, "a < b");
    CHECK(rows.find("| **default** | as it is | 1 s |") != std::string::npos);
    CHECK(rows.find("3.00x") != std::string::npos);
    CHECK(text.find("step, half: costs 2.00 times as long and is 4 times as accurate.") != std::string::npos);
    CHECK(text.find("step, double: takes 0.50 of the time and is 4 times less accurate.") !=
          std::string::npos);
    CHECK(text.find("skipping, off: costs 3.00 times as long and makes no difference to the error.") !=
          std::string::npos);
    CHECK(svg.find("a &lt; b") != std::string::npos);
    CHECK(svg.rfind("</svg>\n") == svg.size() - 7);
  }
  TEST_CASE(
      "voxels beside perceptrons: the first run that is as good, the best within a time, and how many times "
      "as fast") {
    std::vector<Record> versus;
    const auto add = [&](const char* system, double seconds, double db, double memory) {
      versus.push_back(point(system, "", seconds, std::pow(10, -db / 20)));
      versus.back().suite = "versus";
      versus.back().quality = db;
      versus.back().memory = memory;
    };
    add("voxels", 100, 30.5, 5e8);
    add("voxels", 4, 24.5, 4e8);
    add("voxels", 2, 16, 3e8);
    add("voxels", 1, 14, 0);
    add("MLP spline", 120, 13, 2e9);
    add("MLP spline", 600, 15, 2e9);
    const std::string text = versus_table(versus);
    CHECK(
        text.find("| voxels | 4.0 s | 100.0 s | 100.0 s | 30.50 | 30.50 (100 s) | 30.50 (100 s) | 0.50 |") !=
        std::string::npos);
    CHECK(text.find("| MLP spline | not in 600 s | not in 600 s | not in 600 s | 13.00 | 15.00 | 15.00 (600 "
                    "s) | 2.00 |") != std::string::npos);
    CHECK(text.find("the voxels pass that (16.00 dB) in 2.00 s: 300 times as fast.") != std::string::npos);
    std::vector<Record> long_ones = versus;  // without the shortest run nobody knows the factor
    std::erase_if(long_ones, [](const Record& r) { return r.seconds.value == 1; });
    CHECK(versus_table(long_ones).find("the voxels' shortest run has 16.00 dB in 2.00 s already") !=
          std::string::npos);
    versus.push_back(versus.back());
    versus.back().quality = 35;
    CHECK(versus_table(versus).find("do not come to the 35.00 dB") != std::string::npos);
    versus.push_back(point(kBackgroundAlone, "white", 0, 0.2));
    versus.back().suite = "versus";
    versus.back().quality = 12.5;
    CHECK(versus_table(versus).find("nothing but the white background has 12.50 dB.") != std::string::npos);
    CHECK(diagram(versus, "").find("background alone") == std::string::npos);
  }
  TEST_CASE("medians and their intervals") {
    const Figure f = median_of({3, 1, 2, 5, 4});
    CHECK(f.value == 3);
    CHECK(f.lo >= 1);
    CHECK(f.hi <= 5);
    CHECK(f.lo < f.hi);
    CHECK(median_of({1, 2}).value == 1.5);
    CHECK(median_of({7}).lo == 7);
  }
  TEST_CASE("curves are called by what tells their runs apart") {
    const splinevox::test::TempFolder folder;
    std::vector<std::string> runs;
    for (const std::string scene : {"dnerf_lego", "dnerf_mutant"}) {
      runs.push_back(folder.str() + "/fast/" + scene + "/1");
      splinevox::test::write_text(runs.back() + "/metrics.jsonl",
                                  "{\"held_view\": \"r_1\", \"held_psnr\": 30, \"seconds\": "
                                  "2}\n{\"held_view\": \"r_1\", \"held_psnr\": 31, \"seconds\": 4}\n");
    }
    const std::string several = curves(runs), one = curves({runs[0] + "/"});
    CHECK(several.find(">lego</text>") != std::string::npos);
    CHECK(several.find(">mutant</text>") != std::string::npos);
    CHECK(one.find(">1</text>") != std::string::npos);
  }
  TEST_CASE("candidates are run once to warm up and once a round") {
    int a = 0, b = 0;
    const auto timed = interleave({{"a", [&] { ++a; }}, {"b", [&] { ++b; }}}, 4);
    CHECK(a == 5);
    CHECK(b == 5);
    CHECK(timed[0].ratio.value == 1);
    CHECK(timed[1].seconds.value >= 0);
  }
}
