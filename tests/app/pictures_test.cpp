// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

/// A run and its renders, as another method would leave them.
struct Renders : BallScene {
  Renders() {
    REQUIRE(program(train("run", "30", {"--set", "effects.steps=0"})).code == 0);
    REQUIRE(program({"render", run, "--camera", "dataset:test", "--out", pictures, "--quiet"}).code == 0);
  }
  /// A folder with the true pictures of the test split.
  std::string truths(const std::string& name) const {
    fs::copy(data + "/test", path(name));
    return path(name);
  }
  const std::string run = path("run"), pictures = path("pictures");
};

/// Of all cases: they change nothing of the run but the figures that eval keeps.
const Renders& renders() {
  static const Renders out;
  return out;
}

Json figures(std::vector<std::string> words) {
  words.insert(words.begin(), "eval");
  words.push_back("--json");
  const Ended e = program(words);
  CAPTURE(e.err);
  REQUIRE(e.code == 0);
  return Json::parse(e.out);
}

TEST_SUITE("app/pictures") {
  TEST_CASE("a run's renders, scored as another method's, have the run's figures") {
    const Renders& scene = renders();
    const Json own = figures({scene.run});
    const std::string kept = slurp(scene.run + "/metrics.json");
    const std::string out = scene.path("theirs.json");
    const Json theirs = figures({scene.run, "--pictures", scene.pictures, "--match", "order", "--out", out});
    CHECK(slurp(scene.run + "/metrics.json") == kept);
    Json kept_figures = theirs;  // without what an event has beside them
    for (const char* key : {"event", "timestamp", "run_id", "verb", "notes"}) kept_figures.erase(key);
    CHECK(Json::parse(slurp(out)) == kept_figures);
    REQUIRE(theirs["frames"].size() == own["frames"].size());
    for (std::size_t i = 0; i < own["frames"].size(); ++i) {
      const Json &a = own["frames"][i], &b = theirs["frames"][i];
      CHECK(a["name"] == b["name"]);
      CHECK(b["psnr"].get<double>() == doctest::Approx(a["psnr"].get<double>()).epsilon(0.01));
      CHECK(b["ssim"].get<double>() == doctest::Approx(a["ssim"].get<double>()).epsilon(0.01));
    }
    const Json alone = figures({"--data", scene.data, "--pictures", scene.pictures, "--match", "order"});
    CHECK(alone["frames"] == theirs["frames"]);
    CHECK(alone["background"] == Json{1.0, 1.0, 1.0});
    CHECK(figures({"--data", scene.data, "--pictures", scene.pictures, "--match", "order", "--background",
                   "black"})["psnr"] != theirs["psnr"]);
  }

  TEST_CASE("names lead to frames, whatever else lies beside the pictures") {
    const Renders& scene = renders();
    const std::string same = scene.truths("same");
    write_text(same + "/readme.txt", "not a picture");
    write_text(same + "/.hidden.png", "not a picture either");
    const Json perfect = figures({scene.run, "--pictures", same});
    CHECK(perfect["psnr"] == 100);
    CHECK(perfect["ssim"] == doctest::Approx(1));
    CHECK(perfect["match"] == "name");
    const Ended told = program({"eval", scene.run, "--pictures", same});
    CHECK(contains(told.out, "r_0 "));
    CHECK(contains(told.out, "100.000"));
  }

  TEST_CASE("what does not fit is an error that names it") {
    const Renders& scene = renders();
    const auto refused = [&](const std::string& folder, const std::vector<std::string>& says,
                             std::vector<std::string> more = {}) {
      more.insert(more.begin(), {"eval", scene.run, "--pictures", folder});
      const Ended e = program(more);
      CAPTURE(e.err);
      CHECK(e.code == 2);
      for (const std::string& part : says) CHECK(contains(e.err, part));
    };
    refused(scene.pictures, {"frames have no picture", "'r_0'", "'rgb_0001.png'", "--match order"});
    std::string folder = scene.truths("missing");
    fs::remove(folder + "/r_1.png");
    refused(folder, {"1 of 3 frames have no picture", "none for 'r_1'"});
    refused(folder, {"not as many pictures as frames", "3, one of each frame of the test split", "2: "},
            {"--match", "order"});
    folder = scene.truths("surplus");
    fs::copy(folder + "/r_1.png", folder + "/r_9.png");
    refused(folder, {"1 of 4 pictures are of no frame", "'r_9.png'"});
    folder = scene.truths("twice");
    fs::copy(folder + "/r_1.png", folder + "/r_1.jpg");
    refused(folder, {"two pictures are of one frame", "'r_1.jpg', 'r_1.png'"});
    folder = scene.truths("large");
    write_png(folder + "/r_2.png", {2, 2, 8, PngKind::rgba, Bytes(16, 255)});
    refused(folder, {"r_2.png", "not of the size of its frame", "24 x 24", "2 x 2"});
    write_text(folder + "/r_2.png", "no picture");
    refused(folder, {"r_2.png"});
    fs::create_directory(scene.path("empty"));
    refused(scene.path("empty"), {"no pictures in this folder"});
    refused(scene.path("nowhere"), {"no such folder"});
    refused(scene.pictures, {"--images"}, {"--images", scene.path("images")});
    CHECK(contains(program({"eval", "--pictures", scene.pictures}).err, "a RUN, or --data DATASET"));
    CHECK(contains(program({"eval"}).err, "there is no RUN to measure"));
    write_text(scene.path("mine.json"), "{\"mine\": 1}");
    CHECK(program({"eval", scene.run, "--out", scene.path("mine.json")}).code == 2);
    CHECK(contains(program({"eval", scene.run, "--antialias", "0"}).err, "auto, or 1 to 8"));
    CHECK(program({"eval", scene.run, "--pictures", scene.pictures, "--antialias", "2"}).code == 2);
  }

  TEST_CASE("figures go where a link leads that the user named") {
    const Renders& scene = renders();
    const std::string link = scene.path("latest.json");
    REQUIRE(program({"eval", scene.run, "--out", scene.path("first.json")}).code == 0);
    fs::create_symlink(scene.path("first.json"), link);
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{},
          std::vector<std::string>{"--pictures", scene.pictures, "--match", "order"}}) {
      std::vector<std::string> words{"eval", scene.run, "--out", link};
      words.insert(words.end(), more.begin(), more.end());
      const Ended e = program(words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
      CHECK(fs::is_symlink(link));
      CHECK(Json::parse(slurp(scene.path("first.json"))).contains("psnr"));
    }
  }

  TEST_CASE("another program's figures stand beside ours, of each picture and of all") {
    const Renders& scene = renders();
    // How long the files' names are together, and a number for each line of the list.
    const std::string script = scene.path("count.sh");
    write_text(script, "test -s \"$1\" && test -s \"$2\" && basename \"$1\" | cut -c 6\n");
    const Json found = figures({scene.run, "--metric", "digit=sh " + script, "--metric",
                                "lines=cat {list} | while read a b; do test -s \"$a\" -a -s \"$b\" && echo "
                                "2.5; done"});
    CHECK(found["metrics"] == Json{{"digit", 1.0}, {"lines", 2.5}});  // 0, 1 and 2
    CHECK(found["frames"][2]["metrics"] == Json{{"digit", 2.0}, {"lines", 2.5}});
    CHECK(Json::parse(slurp(scene.run + "/metrics.json"))["metrics"] == found["metrics"]);
    CHECK(contains(program({"eval", scene.run, "--metric", "digit=sh " + script}).out, "digit "));
    program({"eval", scene.run});
    CHECK_FALSE(Json::parse(slurp(scene.run + "/metrics.json")).contains("metrics"));  // of no command now

    const auto refused = [&](const std::string& metric, const std::string& says) {
      const Ended e = program({"eval", scene.run, "--metric", metric});
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(contains(e.err, says));
    };
    refused("lpips", "does not begin with a name");
    refused("my lpips=true", "does not begin with a name");
    refused("lpips=", "there is no command");
    refused("lpips=echo no such module >&2; exit 3 #", "no such module");
    refused("lpips=no_such_program_at_all", "no_such_program_at_all");
    refused("lpips=echo a number is 3 #", "a number is 3");
    refused("lpips=echo nan #", "one number and nothing else");
    refused("lpips=cat {list} > /dev/null; echo 1", "3 numbers, one a line");
    CHECK(program({"eval", scene.run, "--metric", "a=echo 1 #", "--metric", "a=echo 2 #"}).code == 2);
  }
}

}  // namespace
