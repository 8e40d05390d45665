// SPDX-License-Identifier: Apache-2.0
// The page of `view` in a headless browser, drawn by software: its pictures beside ours. Skipped where there
// is no Chromium.
#include <doctest/doctest.h>

#include <algorithm>

#include "field/lattice/slice.hpp"
#include "run/edit_session.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"
#include "view_page.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

/// With every effect; made once.
Page& whole_page() {
  static Page page;
  if (page.text.empty()) page.make({"--effects", "all"});
  return page;
}

/// Numbers of control points, of every basis, whose weights the page is asked for.
Json points_asked() {
  Json out;
  for (const Basis& basis : all_bases())
    for (const int points : {2, 3, 4, 5, 12, 13, 20})
      if (basis.points.allows(points)) out[basis.name].push_back(points);
  return out;
}

}  // namespace

TEST_SUITE("app/view") {
  TEST_CASE("a page keeps to its size, says what it cost, and is refused where it cannot") {
    const Page& page = whole_page();
    CHECK_FALSE(page.header.contains("taken"));  // cameras are all around
    for (const char* part : {"src=\"http", "href=\"http", "import(", "<script src", "fetch("})
      CHECK_FALSE_MESSAGE(contains(page.text, part), part);
    const double whole = double(page.text.size()) * 1e-6, limit = 0.85 * whole;
    const Ended smaller = program({"view", page.path("run"), "--out", page.path("small.html"), "--views", "3",
                                   "--split", "train", "--max-mb", std::to_string(limit)});
    CAPTURE(smaller.err);
    REQUIRE(smaller.code == 0);
    CHECK(double(slurp(page.path("small.html")).size()) <= limit * 1e6);
    CHECK_FALSE(contains(smaller.out, "density in 12 bits"));
    const Ended refused =
        program({"view", page.path("run"), "--out", page.path("none.html"), "--max-mb", "0.05"});
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "--max-mb"));
    CHECK_FALSE(std::filesystem::exists(page.path("none.html")));
    CHECK(program({"view", page.path("run"), "--out", page.path("bare.html"), "--views", "0"}).code == 0);
  }

  TEST_CASE("in a browser it shows what we render: every layer, three times; the slider moves the picture") {
    if (browser().empty()) {
      MESSAGE("skipped: there is no Chromium here (apt-get install chromium)");
      return;
    }
    struct Kind {
      std::string what;
      std::vector<std::string> training, editing, look = {};  ///< of a run of its own
    };
    for (const Kind& kind :
         {Kind{"all effects", {}, {}},
          Kind{"Hermite there and back, harmonics of order 3",
               {"--effects", "motion,view", "--set", "motion.basis=bezier", "--set", "radiance.sh_order=3"},
               {"--basis", "hermite", "--ping-pong", "2"}},
          Kind{"light alone, no harmonics", {"--effects", "light"}, {}},
          Kind{"presence beside motion and light, Hermite",
               {"--effects", "motion,light,presence"},
               {"--basis", "hermite:20"}},
          Kind{"presence alone", {"--effects", "presence"}, {}},
          Kind{"nothing changes", {"--effects", "view"}, {}},
          Kind{"a learned background",
               {"--effects", "motion,background", "--set", "run.background_order=3"},
               {},
               {"--opaque"}}}) {
      CAPTURE(kind.what);
      Page own;
      if (!kind.training.empty()) own.make(kind.training, kind.editing, kind.look);
      Page& page = kind.training.empty() ? whole_page() : own;
      page.open(R"js(
  result.pictures = [];
  for (let view = 0; view < 3; ++view) for (const layer of app.state.layers) {
    const {width, height} = app.header.views[view].camera;
    result.pictures.push({view, layer, png: app.picture(`view=${view}&layer=${layer}`, width, height)});
  }
  app.picture("view=1&layer=rgb", 32, 32);
  const slider = document.getElementById("time"), slid = t => {
    slider.value = t;
    slider.dispatchEvent(new Event("input"));
    return app.painter.picture(app.state.look, 32, 32).toDataURL();
  };
  result.slid = [slid(0.05), slid(0.8), slid(0.05)];
  result.weights = [];
  const points = )js" +
                points_asked().dump() + R"js(;
  const curves = [[], [[0, 0.2], [0.5, 1], [0.5, 0.3], [1, 0]]];
  for (const basis in points) for (const k of points[basis]) for (const time_curve of curves)
    for (const t of [0, 0.1, 0.37, 0.5, 0.99, 1]) {
      const w = [...storedWeights({basis, points: k, stored: k, time_curve}, t)];
      result.weights.push({basis, points: k, t, time_curve, w});
    }
  result.fetched = performance.getEntriesByType("resource").filter(r => !r.name.startsWith("data:")).length;
  result.address = app.state.write();
)js");
      CHECK(page.console == "");
      CHECK(page.result["problem"] == "");
      CHECK(page.result["fetched"] == 0);
      CHECK(page.result["address"].get<std::string>().substr(0, 7) == "#t=0.05");

      const run::Run run = run::open_run(page.path(page.run));
      const std::size_t layers = !run.model.motion.moves() ? 2 : run.model.motion.rigidity ? 5 : 4;
      CHECK(page.result["pictures"].size() == 3 * layers);
      Renderer renderer(run.model);
      const VoxelModel parts =
          run.model.motion.moves() ? run::painted(run.model, find_clusters(run.model, 0)) : run.model;
      Renderer part_renderer(parts);
      double least = kPsnrCap;
      for (const Json& p : page.result["pictures"]) {
        const int view = p["view"];
        const Camera camera = page.camera(view);
        const Rendered r = renderer.render(camera, page.header["views"][view]["time"]);
        const bool cluster = p["layer"] == "cluster";
        const Image ours = cluster
                               ? clamped(part_renderer.render(camera, page.header["views"][view]["time"]).rgb)
                               : run::layer_picture(run.model, r, p["layer"], camera);
        const Image theirs = page.picture(p["png"]);
        REQUIRE(theirs.width == ours.width);
        const double db = psnr(ours, theirs);
        CAPTURE(view);
        CAPTURE(p["layer"].get<std::string>());
        CHECK(db > 40);
        least = std::min(least, db);
      }
      MESSAGE(kind.what << ": the least of " << page.result["pictures"].size() << " pictures has " << least
                        << " dB");
      const double slid =
          mean_squared_error(page.picture(page.result["slid"][0]), page.picture(page.result["slid"][1]));
      CHECK((slid > 1e-5) == !run.model.motion.levels.empty());
      CHECK(page.result["slid"][0] == page.result["slid"][2]);

      double apart = 0;
      for (const Json& j : page.result["weights"]) {
        MotionField motion;
        motion.basis = find_basis(j["basis"].get<std::string>())->kind;
        for (const Json& k : j["time_curve"]) motion.time_curve.knots.push_back({k[0], k[1]});
        motion.points = j["points"];
        motion.first_point = FirstPoint::free;
        const BasisWeights<float> ours = stored_weights(motion, j["t"].get<double>());
        for (std::size_t k = 0; k < j["w"].size(); ++k)
          apart = std::max(apart, std::abs(double(ours[k]) - j["w"][k].get<double>()));
      }
      CHECK(apart < 1e-6);
    }
  }

  TEST_CASE("on a telephone's screen every control is on it and does what it says") {
    if (browser().empty()) {
      MESSAGE("skipped: there is no Chromium here (apt-get install chromium)");
      return;
    }
    Page& page = whole_page();
    page.console.clear();
    page.open(R"js(
  const $$ = id => document.getElementById(id);
  const seen = () => app.painter.picture(app.state.look, 32, 32).toDataURL();
  result.screen = [innerWidth, innerHeight, document.documentElement.scrollWidth];
  result.boxes = ["play", "time", "layers", "speed", "compare", "reset", "canvas"].map(id => {
    const b = $$(id).getBoundingClientRect();
    return [id, b.left, b.top, b.right, b.bottom];
  });
  $$("reset").click(), app.set({time: 0.25});
  const first = seen();
  $$("speed").value = "2", $$("speed").dispatchEvent(new Event("change"));
  $$("play").click();
  result.playing = app.state.playing;
  // a busy machine draws few frames: wait until they have come far enough, not for a time
  for (let frames = 0; frames < 200 && app.state.time <= 0.3; ++frames)
    await new Promise(requestAnimationFrame);
  $$("play").click();
  result.went = [app.state.speed, app.state.time, app.state.playing];
  app.set({time: 0.25});
  const canvas = $$("canvas"), middle = canvas.getBoundingClientRect();
  const clientY = middle.top + middle.height / 2;
  const at = (type, dx) => {
    const clientX = middle.left + middle.width / 2 + dx;
    canvas.dispatchEvent(new PointerEvent(type, {pointerId: 7, clientX, clientY, buttons: 1, bubbles: true}));
  };
  canvas.setPointerCapture = () => {};  // a made-up finger cannot be captured
  at("pointerdown", 0), at("pointermove", 60), at("pointerup", 60);
  const turned = seen();
  canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: 400, cancelable: true}));
  const zoomed = seen();
  $$("compare").click();
  const truth = $$("truth").getBoundingClientRect();
  result.compared = [app.state.compare, truth.width > 40 && truth.height > 40 && truth.right <= innerWidth];
  $$("compare").click();
  document.querySelector("#layers button[data-layer=depth]").click();
  result.layer = app.state.layer;
  document.querySelector("#layers button[data-layer=rgb]").click();
  $$("reset").click(), app.set({time: 0.25});
  result.pictures = [turned !== first, zoomed !== turned, seen() === first];
)js",
              "390,844");
    CHECK(page.console == "");
    CHECK(page.result["problem"] == "");
    const double wide = page.result["screen"][0], high = page.result["screen"][1];
    CHECK(wide <= 560);  // below which style.css lays out for a hand
    CHECK(page.result["screen"][2].get<double>() <= wide);
    for (const Json& b : page.result["boxes"]) {
      CAPTURE(b.dump());
      CHECK(b[1].get<double>() >= 0);
      CHECK(b[2].get<double>() >= 0);
      CHECK(b[3].get<double>() <= wide);
      CHECK(b[4].get<double>() <= high);
      CHECK(b[3].get<double>() - b[1].get<double>() >= 20);
      CHECK(b[4].get<double>() - b[2].get<double>() >= 15);
    }
    CHECK(page.result["playing"] == true);
    CHECK(page.result["went"][0] == 2);
    CHECK(page.result["went"][1].get<double>() > 0.3);
    CHECK(page.result["went"][2] == false);
    CHECK(page.result["compared"] == Json{true, true});
    CHECK(page.result["layer"] == "depth");
    CHECK(page.result["pictures"] == Json{true, true, true});
  }
}
