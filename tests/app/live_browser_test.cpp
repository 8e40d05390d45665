// SPDX-License-Identifier: Apache-2.0
// The live page in a headless browser, drawn by software. Skipped where there is no Chromium. With LOOK in
// the environment the pictures of it by day are whole, which takes software half a minute each.
#include <atomic>
#include <cstdlib>

#include "live_run.hpp"
#include "view_page.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

/// Stands between a browser and a live page. Adds a script to the page, which may await and fills the object
/// `result`; hears what it found; passes on all else. The page is not loaded before the script has ended.
class Between {
 public:
  Between(const LiveRun& run, const std::string& script) : run_(run), script_(script) {
    server_.Get(".*", [this](const httplib::Request& ask, httplib::Response& answer) { pass(ask, answer); });
    server_.Post(".*", [this](const httplib::Request& ask, httplib::Response& answer) {
      if (ask.path != run_.root + "result") return pass(ask, answer);
      result = Json::parse(ask.body);
      done_ = true;
    });
    address = "http://127.0.0.1:" + std::to_string(server_.bind_to_any_port("127.0.0.1")) + run_.root;
    listening_ = std::thread([this] { server_.listen_after_bind(); });
  }
  ~Between() {
    done_ = true;
    server_.stop();
    listening_.join();
  }
  /// Opens the page and waits for the script. @param more  words for the browser, as what it is to write
  void open(const TempFolder& temp, const std::string& window, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"timeout",
                                      "420",
                                      browser(),
                                      "--headless=new",
                                      "--no-sandbox",
                                      "--use-gl=angle",
                                      "--use-angle=swiftshader",
                                      "--enable-unsafe-swiftshader",
                                      "--enable-logging=stderr",
                                      "--hide-scrollbars",
                                      "--timeout=410000",
                                      "--window-size=" + window,
                                      "--user-data-dir=" + temp.str() + "/profile"};
    words.insert(words.end(), more.begin(), more.end());
    words.push_back(address);
    const Ended e = Started(words).wait();
    std::stringstream log(e.err);
    for (std::string line; std::getline(log, line);)
      if (contains(line, "CONSOLE") && !contains(line, "GPU stall due to ReadPixels")) console += line + "\n";
    CAPTURE(console);
    REQUIRE_FALSE(result.is_null());
  }

  std::string address, console;
  Json result;

 private:
  void pass(const httplib::Request& ask, httplib::Response& answer) {
    if (ask.path == run_.root + "hold") {
      comes([&] { return done_.load(); }, 400);
      return;
    }
    if (ask.path == run_.root + "lose") {  // the next question, as a tunnel may
      lose_ = true;
      return;
    }
    if (ask.path == run_.root + "state" && lose_.exchange(false)) {
      answer.status = 502;
      return;
    }
    httplib::Client c = run_.client();
    const httplib::Result said = ask.method == "POST" ? c.Post(ask.target) : c.Get(ask.target);
    if (!said) {
      answer.status = 502;
      return;
    }
    answer.status = said->status;
    std::string body = said->body;
    if (ask.path == run_.root) body.replace(body.rfind("</body>"), 7, added());
    const std::string rules = "Content-Security-Policy";
    if (said->has_header(rules)) answer.set_header(rules, said->get_header_value(rules));
    answer.set_content(body, said->get_header_value("Content-Type"));
  }
  std::string added() const {
    return "<img src=\"hold\" hidden alt=\"\"><script>splinevox.then(async app => {\n  const result = {};\n"
           "  const until = async test => { while (!test()) await new Promise(r => setTimeout(r, 50)); };\n"
           "  const frames = async n => { while (n--) await new Promise(requestAnimationFrame); };\n"
           "  try {\n" +
           script_ +
           "\n  } catch (e) { result.thrown = String(e); }\n"
           "  await fetch(\"result\", {method: \"POST\", body: "
           "JSON.stringify(result)});\n});</script></body>";
  }

  const LiveRun& run_;
  const std::string script_;
  httplib::Server server_;
  std::thread listening_;
  std::atomic<bool> done_ = false, lose_ = false;
};

/// A scene large enough to be looked at, and a run of it that ends when it is told to.
struct Watched {
  TempFolder temp;
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  std::vector<std::string> words() const {
    REQUIRE(program({"synth", "dancer", "--out", path("scene"), "--size", "64", "--frames", "24"}).code == 0);
    return {"train",      path("scene"),
            "--out",      path("run"),
            "--preset",   "draft",
            "--max-time", "600",
            "--live",     "--effects=motion",
            "--threads",  "1",  // the browser draws beside it
            "--set",      "sampling.rays=1024",
            "--set",      "grid.radiance=16,24,32",
            "--set",      "grid.motion=4,8",
            "--set",      "grid.motion_start=0,0.2",
            "--set",      "sampling.occupancy_cells=24",
            "--quiet"};
  }
};

}  // namespace

TEST_SUITE("app/live in a browser") {
  TEST_CASE("the page shows the run as it goes, follows its model, and every button does what it says") {
    if (browser().empty()) {
      MESSAGE("skipped: there is no Chromium here (apt-get install chromium)");
      return;
    }
    const Watched scene;
    LiveRun run(scene.words());
    Between between(run, R"js(
  const text = id => document.getElementById(id).textContent, seen = () =>
    app.painter.picture(app.state.look, 48, 48).toDataURL();
  const first = live.shown;
  app.goTo(1);
  const before = seen();
  app.nudge(0.3, 0, 1), app.set({time: 0.4});
  const axes = JSON.stringify(app.camera.axes);
  await until(() => live.last.step > first);
  $("pause").click();  // then the model is shown at once, whatever it costs
  await until(() => text("phase") === "Paused");
  result.pause = text("pause");
  await until(() => live.shown > first && live.shown >= live.last.step);
  result.models = [first, live.shown];
  result.kept = [JSON.stringify(app.camera.axes) === axes, app.state.time === 0.4];
  app.goTo(1);
  result.another = seen() !== before;
  result.programs = app.gl.programs.size;
  result.error = app.gl.getError();
  await fetch("lose");
  live.askSoon(0);
  await until(() => live.lost);
  result.lost = [$("pause").disabled, text("answer")];
  live.askSoon(0);
  await until(() => !live.lost);
  result.found = [$("pause").disabled, text("answer")];
  for (let i = 0; i < 5; ++i) live.askSoon(0), live.ask();
  document.querySelector("#more summary").click();
  $("quality").click();
  $("add").click();
  await until(() => text("where").includes("of 11:00"));
  document.querySelector("#more summary").click();
  const ids = [...document.querySelectorAll("[id]")].map(e => e.id);
  result.twice = ids.filter((id, i) => ids.indexOf(id) !== i);
  const space = new KeyboardEvent("keydown", {key: " ", bubbles: true, cancelable: true});
  result.ticks = $("follow").dispatchEvent(space);
  $("pause").click();
  await until(() => text("phase") === "Training");
  const step = live.last.step;
  await until(() => live.last.step > step && live.views.length > 1);
  await until(() => $("now").complete && $("true").complete);
  result.pictures = [$("now").naturalWidth, $("true").naturalWidth];
  result.drawn = [...document.querySelectorAll("#live canvas")].map(c =>
    c.getContext("2d").getImageData(0, 0, c.width, c.height).data
      .reduce((n, v, i) => n + (i % 4 === 3 && v > 0), 0));
  result.chips = [...document.querySelectorAll("#chips li")].map(c => c.className + ":" + c.textContent);
  result.log = text("log");
  result.wide = [document.documentElement.scrollWidth, innerWidth];
  result.boxes = ["pause", "stop", "add", "share", "figures", "follow"].map(id => {
    const b = document.getElementById(id).getBoundingClientRect();
    return [id, b.left, b.right, b.width, b.height];
  });
  $("stop").click();
  result.sure = text("stop");
  await frames(3);
  result.still = text("phase");
  $("stop").click();
  await until(() => text("phase") === "Stopped and saved");
  await until(() => live.final);
  result.last = [live.shown, live.last.step];
  const steps = live.views.map(v => v.step);
  result.again = steps.some((s, i) => i > 0 && s <= steps[i - 1]);
  result.disabled = $("pause").disabled && $("stop").disabled;
  result.where = text("where");
  result.answer = text("answer");
)js");
    between.open(scene.temp, "390,844", {"--dump-dom"});
    CHECK(between.console == "");
    const Json& r = between.result;
    CAPTURE(r.dump());
    REQUIRE_FALSE(r.contains("thrown"));
    CHECK(r["models"][1] > r["models"][0]);
    CHECK(r["kept"] == Json{true, true});
    CHECK(r["another"] == true);
    CHECK(r["programs"].get<int>() <= 6);
    CHECK(r["error"] == 0);
    CHECK(r["pause"] == "Go on");
    CHECK(r["lost"] == Json{true, "The training cannot be reached just now. It may have ended."});
    CHECK(r["found"] == Json{false, ""});
    CHECK(r["twice"] == Json::array());
    CHECK(r["ticks"] == true);
    CHECK(r["again"] == false);
    CHECK(r["pictures"][0].get<int>() > 0);
    CHECK(r["pictures"][1].get<int>() > 0);
    for (const Json& dots : r["drawn"]) CHECK(dots.get<int>() > 500);
    CHECK(contains(r["chips"].dump(), "used:motion"));
    CHECK(contains(r["log"], "live page: pause at step"));
    CHECK(r["wide"][0].get<int>() <= r["wide"][1].get<int>());
    for (const Json& box : r["boxes"]) {
      CAPTURE(box.dump());
      CHECK(box[1].get<double>() >= 0);
      CHECK(box[2].get<double>() <= r["wide"][1].get<double>());
      CHECK(box[3].get<double>() >= 10);
      CHECK(box[4].get<double>() >= 8);
    }
    CHECK(r["sure"] == "Press again to stop");
    CHECK(r["still"] == "Training");
    // The last model, where the browser is fast enough: a run waits some seconds for a page, and then ends.
    CHECK(r["last"][0].get<double>() >= r["models"][1].get<double>());
    CHECK(r["disabled"] == true);
    CHECK(contains(r["where"], "in " + scene.path("run")));
    CHECK(r["answer"] == "");
    CHECK(run.wait().code == 130);
  }

  TEST_CASE("it can be looked at: a desk's screen and a telephone's, by day and by night") {
    if (browser().empty()) {
      MESSAGE("skipped: there is no Chromium here (apt-get install chromium)");
      return;
    }
    const Watched scene;
    LiveRun run(scene.words());
    REQUIRE(comes([&] { return run.state()["lines"].size() > 12; }));
    CHECK(run.post("pause") == 200);
    const std::string folder = std::filesystem::current_path().string() + "/live_pictures";
    std::filesystem::create_directories(folder);
    const std::string look = std::getenv("LOOK") ? "true" : "false";
    for (const auto& [window, wide, high] : {std::tuple{"1280,800", 1280, 800}, {"390,844", 390, 844}}) {
      double brightness[2] = {};
      for (const bool light : {false, true}) {
        const std::string file = folder + "/" + window + (light ? "_light.png" : "_dark.png");
        CAPTURE(file);
        Between between(run, R"js(
  await until(() => live.shown >= live.last.step && $("now").complete && $("true").complete);
  app.set({time: 0.5});
  result.dark = matchMedia("(prefers-color-scheme: dark)").matches;
  if (!result.dark && )js" + look +
                                 R"js() await until(() => app.painter.nextRow >= app.canvas.height);
  await frames(4);
  result.size = [innerWidth, innerHeight];
)js");
        between.open(scene.temp, window,
                     {std::string("--blink-settings=preferredColorScheme=") + (light ? "1" : "0"),
                      "--screenshot=" + file});
        CHECK(between.console == "");
        CHECK(between.result["dark"] != light);
        const Image picture = composite(read_png(file), {1, 1, 1});
        CHECK(picture.width == wide);
        CHECK(picture.height == high);
        brightness[light] = picture.pixel(wide - 4, high - 4)[0];
        // What is on the stage is neither empty nor of one colour.
        double least = 1, most = 0;
        for (int y = 100; y < 400; ++y)
          for (int x = wide / 4; x < wide / 2; ++x) {
            least = std::min(least, double(picture.pixel(x, y)[0]));
            most = std::max(most, double(picture.pixel(x, y)[0]));
          }
        CHECK(most - least > 0.3);
      }
      CHECK(brightness[1] > brightness[0] + 0.3);
    }
    CHECK(run.post("stop") == 200);
    CHECK(run.wait().code == 130);
  }
}
