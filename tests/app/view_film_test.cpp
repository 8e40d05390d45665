// SPDX-License-Identifier: Apache-2.0
// The page of `view` where cameras do not surround the scene. Skipped where there is no Chromium.
#include "view_page.hpp"

using namespace splinevox;
using namespace splinevox::test;

TEST_SUITE("app/view") {
  TEST_CASE("of a film it begins at a training camera; away from there it holds back and fades") {
    Page page;
    page.make({}, {}, {"--orbit", "0.15"});
    REQUIRE(page.header.contains("taken"));
    const Json& taken = page.header["taken"];
    CHECK(taken["directions"].size() == 12);
    CHECK(taken["near"].get<double>() <= taken["far"].get<double>());
    if (browser().empty()) {
      MESSAGE("skipped: there is no Chromium here (apt-get install chromium)");
      return;
    }
    page.open(R"js(
  const camera = app.camera, far = document.getElementById("far");
  const told = () => [camera.away, far.hidden, app.canvas.style.filter !== ""];
  result.begins = [app.state.view, camera.position, app.header.start.camera.position, app.state.time];
  result.told = [told()];
  app.nudge(0.02, 0, 1), result.told.push(told());
  for (let i = 0; i < 100; ++i) app.nudge(0.3, 0, 1);
  result.told.push(told());
  const before = camera.away;
  app.nudge(-0.3, 0, 1), result.back = before - camera.away;
  app.reset(), app.nudge(3, 0, 1), result.flick = camera.away;
  app.reset();
  for (let i = 0; i < 100; ++i) app.nudge(0, 0, 0.7);
  result.nearest = [camera.away, camera.distance];
  app.reset(), result.told.push(told());
  app.goTo(2), result.view = told();
)js");
    CHECK(page.console == "");
    CHECK(page.result["problem"] == "");
    CHECK(page.result["begins"][0] == -1);
    for (int a = 0; a < 3; ++a)
      CHECK(page.result["begins"][1][a].get<double>() ==
            doctest::Approx(page.result["begins"][2][a].get<double>()));
    CHECK(page.result["begins"][3] == page.header["start"]["time"]);
    const Json &told = page.result["told"], quiet = {0, true, false};
    CHECK(told[0] == quiet);
    CHECK(told[1] == quiet);
    CHECK(told[2][0].get<double>() > 0.7);
    CHECK(told[2][0].get<double>() < 1);
    CHECK(told[2][1] == false);
    CHECK(told[2][2] == true);
    CHECK(page.result["back"].get<double>() > 0.2);
    CHECK(page.result["flick"].get<double>() < 1);
    CHECK(page.result["nearest"][0].get<double>() < 1);
    CHECK(page.result["nearest"][1].get<double>() > 0.3 * taken["near"].get<double>());
    CHECK(told[3] == quiet);
    CHECK(page.result["view"] == quiet);
  }
}
