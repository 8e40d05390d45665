// SPDX-License-Identifier: Apache-2.0
// What a report says of its runs, and which files it links.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "ball_scene.hpp"
#include "report/page.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;

namespace {

run::ReportRun measured(const std::string& name, double psnr, const std::string& data, int frames) {
  run::ReportRun out;
  out.name = name;
  out.model_file = "model.vdb";
  out.metrics = {{"psnr", psnr}, {"split", "test"}, {"frames", run::Json::array()}};
  if (!data.empty()) out.metrics["eval_data"] = data;
  for (int i = 0; i < frames; ++i) out.metrics["frames"].push_back({{"name", std::to_string(i)}});
  return out;
}

}  // namespace

TEST_SUITE("app/report") {
  TEST_CASE("figures compete that are of the same pictures; of others none is the best") {
    const auto best = [](const run::ReportRun& other) {
      const std::string page = run::report_page({measured("a", 20, "/x/lego", 2), other});
      return std::pair(contains(page, "class=\"best\">20.00"), contains(page, "class=\"best\">30.00"));
    };
    CHECK(best(measured("b", 30, "/y/lego", 2)) == std::pair(false, true));
    CHECK(best(measured("b", 30, "", 2)) == std::pair(false, true));
    CHECK(best(measured("b", 30, "/x/mutant", 2)) == std::pair(false, false));
    CHECK(best(measured("b", 30, "/x/lego", 3)) == std::pair(false, false));
    run::ReportRun none;
    none.name = "none";
    none.metrics = run::Json::object();
    CHECK(best(none) == std::pair(true, false));  // only one has figures
    run::ReportRun small = measured("b", 30, "/x/lego", 2);
    small.metrics["downscale"] = 2;
    CHECK(best(small) == std::pair(false, true));  // what the other does not say may be the same
    run::ReportRun large = measured("a", 20, "/x/lego", 2);
    large.metrics["downscale"] = 1;
    CHECK_FALSE(contains(run::report_page({large, small}), "class=\"best\">30.00"));
  }

  TEST_CASE("the version of a run is that of its training") {
    run::ReportRun one = measured("a", 20, "", 0);
    one.version = "0.0.1";
    CHECK(contains(run::report_page({one}), "reconstructed by splinevox 0.0.1, preset"));
    one.version = "";
    CHECK(contains(run::report_page({one}), "reconstructed by splinevox, preset"));
  }

  TEST_CASE(
      "a page of another run of the same name is not linked, and pictures that were not measured say so") {
    const SmallRun home;
    const std::string other = home.path("b/run");
    REQUIRE(program(home.train("b/run", {"--max-steps", "6"})).code == 0);
    fs::create_directory(home.path("out"));
    REQUIRE(program({"view", home.run, "--out", home.path("out/scene.html")}).code == 0);
    const std::string link = "href=\"scene.html\"", page = home.path("out/report.html");
    const auto report = [&](const std::string& run) {
      const Ended e = program({"report", run, "--out", page, "--views", "1"});
      CAPTURE(e.err);
      CHECK(e.code == 0);
      return slurp(page);
    };
    CHECK(contains(report(home.run), link));
    CHECK_FALSE(contains(report(other), link));

    REQUIRE(program({"eval", home.run}).code == 0);
    CHECK(contains(report(home.run), "the worst views first"));
    const std::string metrics = home.run + "/metrics.json";
    run::Json figures = run::Json::parse(slurp(metrics));
    figures["frames"][0]["name"] = "another";
    write_text(metrics, figures.dump());
    CHECK(contains(report(home.run), "some views, the worst of them first"));
  }
}
