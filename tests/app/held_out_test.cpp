// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>

#include "ball_scene.hpp"
#include "run/support.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

constexpr int kPictures = 16;

std::string picture_name(int i) { return "r_" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png"; }

/// A ball in one list of pictures, of which numbers 4 and 12 are held out, and a run of four steps on it.
struct OneList {
  TempFolder temp;
  std::string data = path("ball"), run = path("run"), list = run + "/training_pictures.txt";
  OneList() {
    std::vector<std::string> frames;
    for (int i = 0; i < kPictures; ++i) {
      const double t = double(i) / (kPictures - 1);
      const std::array<double, 16> m = orbit_matrix(2.4 * i);
      std::ostringstream time;
      time.precision(17);
      time << t;
      frames.push_back(frame_text("images/" + picture_name(i), time.str(), matrix_text(m)));
      write_png(picture(i), ball_png(12, 0.8, m, t));
    }
    write_text(data + "/transforms.json", transforms_text(frames));
    REQUIRE(train({}).code == 0);
  }
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  std::string picture(int i) const { return data + "/images/" + picture_name(i); }
  Ended train(const std::vector<std::string>& more) const {
    std::vector<std::string> words = train_small(data, run, {"--max-steps", "4"});
    words.insert(words.end(), more.begin(), more.end());
    return program(words);
  }
  /// `eval` must refuse all of the test split.
  void check_refused(std::vector<std::string> words) const {
    words.insert(words.begin(), "eval");
    const Ended e = program(words);
    CAPTURE(e.out);
    CAPTURE(e.err);
    CHECK(e.code == 2);
    CHECK(contains(e.err, "2 of 2 pictures of the test split were trained on"));
    CHECK(contains(e.err, "first images/r_05.png"));
    CHECK(contains(e.err, "give missing pictures back"));
  }
  /// Without picture 1 the 5th and the 13th are held out, which were trained on.
  void lose_one() const { fs::rename(picture(1), path("lost.png")); }
  void give_back() const { fs::rename(path("lost.png"), picture(1)); }
};

}  // namespace

TEST_SUITE("app/held_out") {
  TEST_CASE("a run lists what it was trained on, and verify knows the list") {
    const OneList scene;
    const std::string text = slurp(scene.list);
    CHECK(std::count(text.begin(), text.end(), '\n') == kPictures - 2);
    CHECK(contains(text, "images/r_05.png, " + std::to_string(fs::file_size(scene.picture(5))) + " bytes\n"));
    for (const int held_out : {4, 12}) CHECK_FALSE(contains(text, picture_name(held_out)));
    const Ended verify = program({"verify", scene.run});
    CHECK(verify.code == 0);
    CHECK(contains(verify.out, "ok   training_pictures.txt"));
    CHECK(program({"eval", scene.run}).code == 0);
    // A run of an older version that goes on gets the list.
    fs::remove(scene.list);
    fs::remove(scene.run + "/metrics.json");
    const Ended again = scene.train({"--resume"});
    CAPTURE(again.err);
    CHECK(again.code == 0);
    CHECK(slurp(scene.list) == text);
    CHECK(program({"verify", scene.run}).code == 0);
  }

  TEST_CASE("pictures that were trained on are not measured as held out where one is missing") {
    const OneList scene;
    REQUIRE(program({"edit", scene.run, "--out", scene.path("edited"), "--reverse", "--quiet"}).code == 0);
    CHECK(slurp(scene.path("edited") + "/training_pictures.txt") == slurp(scene.list));
    CHECK(contains(program({"verify", scene.path("edited")}).out, "ok   training_pictures.txt"));
    const std::string metrics = slurp(scene.run + "/metrics.json");
    scene.lose_one();
    scene.check_refused({scene.run});
    scene.check_refused({scene.path("edited")});
    CHECK(slurp(scene.run + "/metrics.json") == metrics);
    const Ended render =
        program({"render", scene.run, "--out", scene.path("views"), "--camera", "dataset:test"});
    CHECK(render.code == 2);
    CHECK(contains(render.err, "were trained on"));
    CHECK(program({"report", scene.run, "--out", scene.path("page.html"), "--views", "1"}).code == 0);
    CHECK(contains(slurp(scene.path("page.html")), "were trained on"));
    CHECK(program({"eval", scene.run, "--split", "train"}).code == 0);
    // Wherever the data set lies.
    fs::rename(scene.data, scene.path("moved"));
    scene.check_refused({scene.run, "--data", scene.path("moved")});
    fs::rename(scene.path("moved"), scene.data);
    scene.give_back();
    CHECK(program({"eval", scene.run}).code == 0);
    CHECK(program({"eval", scene.path("edited")}).code == 0);
  }

  TEST_CASE("nor where masks that not all pictures have are used otherwise") {
    const OneList scene;
    for (int i = 0; i < kPictures; ++i)
      if (i != 1)
        write_png(scene.data + "/masks/" + picture_name(i),
                  TinyPng{12, 12, 8, PngKind::grey, Bytes(std::size_t(12 * 12), 255)});
    CHECK(program({"eval", scene.run}).code == 0);
    scene.check_refused({scene.run, "--masks", "subject"});
  }

  TEST_CASE("a run without the list and pictures of another data set are evaluated as ever") {
    const OneList scene;
    const std::string other = scene.path("other");
    fs::copy(scene.data, other, fs::copy_options::recursive);
    fs::remove(other + "/images/" + picture_name(1));
    for (int i = 0; i < kPictures; ++i)  // other pictures of these names: no alpha, so fewer bytes
      if (i != 1)
        write_png(other + "/images/" + picture_name(i),
                  TinyPng{12, 12, 8, PngKind::rgb, Bytes(std::size_t(3 * 12 * 12), 90)});
    REQUIRE(program({"eval", scene.run}).code == 0);
    const std::string metrics = slurp(scene.run + "/metrics.json"), out = scene.path("other.json");
    const Ended eval = program({"eval", scene.run, "--data", other, "--out", out});
    CAPTURE(eval.err);
    CHECK(eval.code == 0);
    CHECK(contains(eval.out, "of another data set: the run does not keep their figures"));
    CHECK(slurp(scene.run + "/metrics.json") == metrics);
    CHECK(Json::parse(slurp(out))["psnr"] != Json::parse(metrics)["psnr"]);
    for (const char* name : {"/metrics.json", "/metrics_val.json"}) {
      const Ended own = program({"eval", scene.run, "--data", other, "--out", scene.run + name});
      CHECK(own.code == 2);
      CHECK(contains(own.err, "a run keeps its own figures in this file"));
    }
    CHECK(slurp(scene.run + "/metrics.json") == metrics);
    scene.lose_one();
    fs::remove(scene.list);
    CHECK(program({"eval", scene.run}).code == 0);
  }

  TEST_CASE(
      "a data set whose lists name a picture for both gets a note; one whose lists changed is refused") {
    const SmallRun home;
    const std::string test = home.data + "/transforms_test.json",
                      train = home.data + "/transforms_train.json";
    Json held_out = Json::parse(slurp(test)), training = Json::parse(slurp(train));
    held_out["frames"][0] = training["frames"][0];
    write_text(test, held_out.dump());
    const Ended noted = program({"eval", home.run});
    CAPTURE(noted.err);
    CHECK(noted.code == 0);
    CHECK(
        contains(noted.out, "note: 1 of 2 pictures of the test split were trained on, first train/r_0.png"));
    CHECK(contains(noted.out, "the data set itself has them for both"));
    training["frames"].erase(std::size_t(0));
    write_text(train, training.dump());
    const Ended refused = program({"eval", home.run});
    CHECK(refused.code == 2);
    CHECK(
        contains(refused.err, "1 of 2 pictures of the test split were trained on: the data set is divided"));
  }
}
