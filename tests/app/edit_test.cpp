// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/edit.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "ball_scene.hpp"
#include "run/support.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/render/render_image.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

const BallScene& scene() {
  static const BallScene scene;
  return scene;
}

/// A run with these effects, trained once.
std::string trained(const std::string& effects) {
  const std::string run = scene().path(effects);
  if (!fs::exists(run)) {
    const Ended e = program(scene().train(effects, "150",
                                          {"--effects", effects, "--quiet", "--set", "grid.motion=4,8,16,32",
                                           "--set", "grid.motion_start=0,.08,.25,.5"}));
    CAPTURE(e.err);
    REQUIRE(e.code == 0);
  }
  return run;
}

/// A case's own copy of it.
struct Trained {
  TempFolder temp;
  std::string run = path("run");
  explicit Trained(const char* effects = "motion,light") {
    fs::copy(trained(effects), run, fs::copy_options::recursive);
  }
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  Ended edit(const std::string& from, const std::string& to, std::vector<std::string> operations) const {
    operations.insert(operations.begin(), {"edit", from, "--out", path(to)});
    return program(operations);
  }
};

Camera camera() {
  Camera c;
  c.width = c.height = 40;
  c.fx = c.fy = 60;
  c.cx = c.cy = 20;
  c.axes = {Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{1, 0, 0}};
  c.position = {3, 0, 0};
  return c;
}

/// How far pictures of run a at one time and run b at another are apart, value by value.
std::vector<double> differences(const std::string& a, double at_a, const std::string& b, double at_b) {
  const VoxelModel x = load_model(a + "/model.vdb"), y = load_model(b + "/model.vdb");
  const Image p = render_image(x, camera(), at_a).rgb, q = render_image(y, camera(), at_b).rgb;
  std::vector<double> out;
  for (std::size_t i = 0; i < p.data.size(); ++i) out.push_back(double(std::abs(p.data[i] - q.data[i])));
  return out;
}

double picture_difference(const std::string& a, double at_a, const std::string& b, double at_b) {
  const std::vector<double> all = differences(a, at_a, b, at_b);
  return *std::max_element(all.begin(), all.end());
}

double mean_difference(const std::string& a, double at_a, const std::string& b, double at_b) {
  const std::vector<double> all = differences(a, at_a, b, at_b);
  return std::accumulate(all.begin(), all.end(), 0.0) / double(all.size());
}

}  // namespace

TEST_SUITE("app/edit") {
  TEST_CASE("operations make a new run that every verb reads, and leave the old one alone") {
    const Trained t;
    const std::string model = slurp(t.run + "/model.vdb");
    REQUIRE(t.edit(t.run, "back", {"--reverse"}).code == 0);
    REQUIRE(t.edit(t.path("back"), "forth", {"--reverse"}).code == 0);
    CHECK(slurp(t.path("forth") + "/model.vdb") == model);
    CHECK(slurp(t.run + "/model.vdb") == model);
    for (const double time : {0.0, 0.25, 0.7})
      CHECK(picture_difference(t.path("back"), 1 - time, t.run, time) < 1e-5);
    CHECK(Json::parse(slurp(t.path("forth") + "/edit.json"))["history"].size() == 2);

    REQUIRE(t.edit(t.run, "half", {"--speed", "0.5"}).code == 0);
    for (const double time : {0.0, 0.2, 0.5})
      CHECK(picture_difference(t.path("half"), 2 * time, t.run, time) == 0);
    CHECK(picture_difference(t.path("half"), 1, t.run, 1) > 0.05);

    REQUIRE(t.edit(t.run, "curves", {"--basis", "bezier:6"}).code == 0);
    REQUIRE(t.edit(t.path("curves"), "more", {"--elevate", "7"}).code == 0);
    CHECK(load_model(t.path("more") + "/model.vdb").motion.points == 13);
    for (const double time : {0.0, 0.3, 1.0})
      CHECK(picture_difference(t.path("more"), time, t.path("curves"), time) < 1e-5);

    const std::string run = t.path("half");
    CHECK(program({"verify", run}).code == 0);
    const Ended info = program({"info", run});
    CHECK(info.code == 0);
    CHECK(contains(info.out, "edited"));
    CHECK(contains(info.out, "--speed 0.5"));
    CHECK(program({"eval", run}).code == 0);
    CHECK(program({"render", run, "--out", t.path("pictures"), "--times", "0:1:2", "--size", "16"}).code ==
          0);
    CHECK(program({"export", run, "--out", t.path("vdb"), "--frames", "1-2"}).code == 0);
    CHECK(program({"report", run, "--out", t.path("page.html"), "--views", "1"}).code == 0);
    write_text(t.path("points.csv"), "x,y,z\n0.1,0.2,0.3\n");
    CHECK(
        program({"track", run, "--points", t.path("points.csv"), "--to", "1", "--out", t.path("tracks.csv")})
            .code == 0);
    const Ended resume = program({"train", scene().data, "--out", run, "--resume"});
    CHECK(resume.code == 2);
    CHECK(contains(resume.err, "was made by `splinevox edit`"));
  }
  TEST_CASE("the order of operations is the order of the words") {
    const Trained t;
    REQUIRE(t.edit(t.run, "a", {"--freeze", "0.25", "--reverse"}).code == 0);
    REQUIRE(t.edit(t.run, "b", {"--reverse", "--freeze", "0.25"}).code == 0);
    REQUIRE(t.edit(t.run, "c", {"--speed", "0.5", "--reverse", "--speed", "0.5"}).code == 0);
    CHECK(picture_difference(t.path("a"), 0.9, t.run, 0.25) == 0);
    CHECK(picture_difference(t.path("b"), 0.9, t.run, 0.75) == 0);
    CHECK(picture_difference(t.path("c"), 0.5, t.run, 0.375) < 1e-6);
    const Json history = Json::parse(slurp(t.path("c") + "/edit.json"))["history"][0]["operations"];
    REQUIRE(history.size() == 3);
    CHECK(history[1]["operation"] == "reverse");
    CHECK(history[2]["value"] == "0.5");
  }
  TEST_CASE("every word for parts and for what comes and goes does to a run what it says") {
    const Trained t("motion,light,presence");
    const auto done = [&](const char* name, const std::vector<std::string>& words) {
      const Ended e = t.edit(t.run, name, words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
      return Json::parse(slurp(t.path(name) + "/edit.json"))["history"][0]["operations"].back();
    };
    const std::vector<std::string> ball{"--freeze-presence", "0.5", "--clusters", "2", "--cluster", "moving"};
    const auto of_ball = [&](std::vector<std::string> words) {
      words.insert(words.begin(), ball.begin(), ball.end());
      return words;
    };
    done("steady", {"--freeze-presence", "0.5"});
    CHECK(picture_difference(t.path("steady"), 0.5, t.run, 0.5) < 0.05);
    CHECK_FALSE(load_model(t.path("steady") + "/model.vdb").motion.presence);
    done("mean", {"--scale-presence", "0"});
    done("only", of_ball({"--only"}));
    CHECK(picture_difference(t.path("only"), 0.3, t.path("steady"), 0.3) < 0.1);
    CHECK(done("slow", of_ball({"--slow", "0.5"}))["kept_old_time_share"].get<double>() < 0.02);
    // Pictures of 40 pixels show a few voxels of what the clusters leave out.
    const std::string steady_run = t.path("steady");
    for (const double time : {0.1, 0.4})
      CHECK(mean_difference(t.path("slow"), 2 * time, steady_run, time) <
            0.25 * mean_difference(t.path("slow"), time, steady_run, 2 * time));
    const Json moved = done("moved", of_ball({"--move", "0,0,-0.6"}));
    CHECK(moved["error_max_voxels"].get<double>() < 1);
    const double far = mean_difference(t.path("moved"), 0.3, steady_run, 0.3);
    CHECK(far > 0.01);
    const auto center = [](const VoxelModel& model) { return find_clusters(model, 2).clusters[1].center; };
    const VoxelModel steady = load_model(t.path("steady") + "/model.vdb");
    const Vec3 shift = center(load_model(t.path("moved") + "/model.vdb")) - center(steady);
    CHECK(length(shift - Vec3{0, 0, -0.6f}) < 0.1f);
    done("back",
         of_ball({"--move", "0,0,-0.6", "--clusters", "2", "--cluster", "moving", "--move", "0,0,0.6"}));
    CHECK(mean_difference(t.path("back"), 0.3, steady_run, 0.3) < 0.2 * far);
    CHECK(done("turned", of_ball({"--rotate", "z,180,0,0,1"}))["operation"] == "rotate");
    done("clean", {"--remove-floaters", "0.001"});
    CHECK(picture_difference(t.path("clean"), 0.3, t.run, 0.3) < 0.1);
    done("anchored", {"--freeze-presence", "0.5", "--anchor-first"});
    CHECK(mean_difference(t.path("anchored"), 0, steady_run, 0) < 0.2 * far);
  }
  TEST_CASE("parts are found, hidden and painted; what makes no sense is refused and leaves nothing behind") {
    const Trained t;
    const Ended parts = t.edit(t.run, "parts", {"--clusters", "2", "--cluster", "moving", "--hide"});
    CAPTURE(parts.err);
    REQUIRE(parts.code == 0);
    CHECK(contains(parts.out, "stands still"));
    REQUIRE(t.edit(t.run, "paint", {"--clusters", "auto", "--paint"}).code == 0);
    struct Row {
      std::vector<std::string> words;
      const char* says;
    };
    for (const Row& row :
         {Row{{}, "there is nothing to do"}, Row{{"--speed", "0"}, "out of range"},
          Row{{"--loop", "1.5"}, "not a whole number"}, Row{{"--time-curve", "0:0,0.7:1"}, "ends at time 1"},
          Row{{"--time-curve", "0:0,0.7:1,0.6:0,1:1"}, "must not go back"},
          Row{{"--basis", "spline"}, "try:      --basis bspline"},
          Row{{"--basis", "poly-bezier"}, "try:      --basis poly_bezier"},
          Row{{"--basis", "hermite:5"}, "5 points do not suit hermite"},
          Row{{"--elevate", "1"}, "no degree to elevate"}, Row{{"--hide"}, "there are no clusters yet"},
          Row{{"--clusters", "2", "--hide"}, "no cluster is chosen"},
          Row{{"--clusters", "2", "--cluster", "9"}, "from 0 to 1"},
          Row{{"--clusters", "2", "--cluster", ",", "--only"}, "names no cluster"},
          Row{{"--clusters", "2", "--cluster", "1", "--rotate", "w,3"}, "this is not a rotation"}}) {
      const Ended e = t.edit(t.run, "refused", row.words);
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(contains(e.err, row.says));
      CHECK_FALSE(fs::exists(t.path("refused")));
    }
    const Ended full = t.edit(t.run, "parts", {"--reverse"});
    CHECK(full.code == 2);
    CHECK(contains(full.err, "already holds a run"));
  }
}
