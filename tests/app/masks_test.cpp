// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

/// The ball before a wall, opaque, with masks that show where it is.
struct WallScene : BallScene {
  WallScene() {
    for (const auto& [split, count] : {std::pair{"train", 12}, {"val", 2}, {"test", 3}}) {
      const std::string file = data + "/transforms_" + split + ".json";
      const Json frames = Json::parse(slurp(file))["frames"];
      for (int i = 0; i < count; ++i) {
        const Json& matrix = frames[std::size_t(i)]["transform_matrix"];
        std::array<double, 16> m{};
        for (std::size_t k = 0; k < 16; ++k) m[k] = matrix[k / 4][k % 4].get<double>();
        TinyPng png = ball_png(24, 0.8, m, frames[std::size_t(i)]["time"].get<double>());
        TinyPng mask{24, 24, 8, PngKind::grey, {}};
        for (std::size_t p = 0; p < png.rows.size(); p += 4) {
          mask.rows.push_back(png.rows[p + 3]);
          if (png.rows[p + 3] == 0)
            for (std::size_t c = 0; c < 3; ++c) png.rows[p + c] = std::uint8_t(40 * ((p / 4 / 3 + c) % 5));
          png.rows[p + 3] = 255;
        }
        const std::string name = std::string(split) + "/r_" + std::to_string(i) + ".png";
        write_png(data + "/" + name, png);
        write_png(data + "/masks/" + name, mask);
      }
    }
  }
};

TEST_SUITE("app/masks") {
  TEST_CASE("unused masks: a note, and figures inside them beside those of whole pictures") {
    const WallScene scene;
    const Ended info = program({"info", scene.data});
    CAPTURE(info.out);
    CHECK(contains(info.out, "masks  of 17 of 17 pictures, not used; white on average"));
    CHECK(contains(info.out, "note: masks are not used: 17 of 17"));
    const Ended train = program(scene.train("run", "30", {"--set", "effects.steps=0"}));
    CAPTURE(train.err);
    REQUIRE(train.code == 0);
    CHECK(contains(train.err, "note: masks are not used: 14 of 14"));
    const Ended eval = program({"eval", scene.path("run")});
    CAPTURE(eval.out);
    REQUIRE(eval.code == 0);
    CHECK(contains(eval.out, "inside the masks"));
    const Json metrics = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    CHECK(metrics["inside_views"] == 3);
    CHECK(metrics["inside_share"] > 0.02);
    CHECK(metrics["inside_share"] < 0.6);
    CHECK(metrics["frames"][0]["psnr_inside"] != metrics["frames"][0]["psnr"]);
    double sum = 0;
    for (const Json& frame : metrics["frames"]) sum += frame["psnr_inside"].get<double>();
    CHECK(metrics["psnr_inside"].get<double>() == doctest::Approx(sum / 3));
    REQUIRE(program({"report", scene.path("run"), "--out", scene.path("page.html")}).code == 0);
    CHECK(contains(slurp(scene.path("page.html")), "PSNR inside the masks"));
    CHECK(contains(program({"info", scene.path("run")}).out, "inside the masks: PSNR"));
    const Ended none = program({"eval", scene.path("run"), "--masks", "none"});
    CHECK(none.code == 0);
    CHECK_FALSE(contains(none.out, "mask"));
  }

  TEST_CASE("the run remembers what masks are for") {
    const WallScene scene;
    for (const std::string use : {"subject", "ignore", "ignore-white", "moving"}) {
      CAPTURE(use);
      const std::string run = scene.path("run_" + use);
      const std::vector<std::string> words = scene.train("run_" + use, "20", {"--set", "effects.steps=0"});
      std::vector<std::string> with = words;
      with.insert(with.end(), {"--masks", use});
      const Ended train = program(with);
      CAPTURE(train.err);
      REQUIRE(train.code == 0);
      CHECK(contains(slurp(run + "/config.toml"), "masks = \"" + use + "\""));
      std::vector<std::string> again = words;
      again.insert(again.end(), {"--resume"});
      CHECK(program(again).code == 0);
      again.insert(again.end(), {"--masks", "none"});
      const Ended other = program(again);
      CHECK(other.code == 2);
      CHECK(contains(other.err, "the run was made from other training data"));
      const Ended eval = program({"eval", run});
      CAPTURE(eval.out);
      CHECK(eval.code == 0);
      const Json metrics = Json::parse(slurp(run + "/metrics.json"));
      CHECK_FALSE(metrics.contains("psnr_inside"));
      CHECK(metrics.contains("ignored_share") == use.starts_with("ignore"));
      CHECK(contains(eval.out, "of all pixels are ignored") == use.starts_with("ignore"));
    }
  }

  TEST_CASE("masks of what moves stand in for a still world") {
    const WallScene scene;
    const Ended whole =
        program(scene.train("whole", "60", {"--set", "effects.steps=5", "--masks", "moving"}));
    CAPTURE(whole.err);
    REQUIRE(whole.code == 0);
    CHECK(contains(whole.err, "masks say what moves: what is white may, all else stands still"));
    CHECK(contains(whole.err, "% of the pixels, in "));
    const Json film = Json::parse(slurp(scene.path("whole") + "/effects.json"))["film"];
    CHECK(film["given"] == true);
    CHECK(film["moves"] == true);
    CHECK(film["share"] > 0.02);
    CHECK_FALSE(film.contains("psnr"));
    CHECK(contains(program({"info", scene.data, "--masks", "moving"}).out, "17 of 17 pictures, moving"));
  }

  TEST_CASE("what cannot be is said") {
    const WallScene scene;
    const Ended word = program(scene.train("run", "10", {"--masks", "figure"}));
    CHECK(word.code == 2);
    CHECK(contains(word.err, "--masks: there is no such use of masks"));
    fs::remove_all(scene.data + "/masks");
    for (const std::string verb : {"train", "info", "convert"}) {
      CAPTURE(verb);
      std::vector<std::string> words{verb, scene.data, "--masks", "subject"};
      if (verb != "info") words.insert(words.end(), {"--out", scene.path("none")});
      const Ended none = program(words);
      CHECK(none.code == 2);
      CHECK(contains(none.err, "--masks subject was asked for, but no picture has a mask"));
    }
    CHECK_FALSE(fs::exists(scene.path("none")));
  }
}

}  // namespace
