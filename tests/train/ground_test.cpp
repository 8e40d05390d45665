// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/small_run.hpp"
#include "train/bounds/hull.hpp"
#include "train/check_cameras.hpp"

using namespace splinevox;

namespace {

Dataset ball_on(bool opaque) {
  return make_synth("ball", {.frames = 24, .size = 48, .look = {.opaque = opaque}});
}

Prepared prepared(const Config& config, Dataset& data) {
  return prepare(config, data, {.effects = EffectPolicy::keep});
}

/// The notes of a check.
template <class Check>
std::vector<std::string> notes_of(const Check& check) {
  std::vector<std::string> notes;
  check([&](std::string text) { notes.push_back(std::move(text)); });
  return notes;
}

}  // namespace

TEST_SUITE("train/ground") {
  TEST_CASE("a plain ground is found and cut out as far as it is sure, and nothing else") {
    Dataset opaque = ball_on(true);
    const Dataset truth = ball_on(false);
    Split& train = *opaque.find("train");
    const std::optional<Vec3> colour = find_ground(train);
    REQUIRE(colour);
    const double share = cut_ground(train, *colour);
    std::size_t ground = 0, kept_ground = 0, pixels = 0;
    for (std::size_t f = 0; f < train.frames.size(); ++f)
      for (std::size_t i = 0; i < train.frames[f].image.pixels(); ++i) {
        const bool cut = train.frames[f].image.pixel(i)[3] == 0,
                   empty = truth.find("train")->frames[f].image.pixel(i)[3] == 0;
        if (cut) CHECK(empty);
        ground += empty ? 1 : 0;
        kept_ground += empty && !cut ? 1 : 0;
        ++pixels;
      }
    CHECK(double(kept_ground) < 0.25 * double(ground));  // the ring around what is shown
    CHECK(share == doctest::Approx(double(ground - kept_ground) / double(pixels)));
    undo_cut(train);
    for (std::size_t f = 0; f < train.frames.size(); ++f)
      CHECK(train.frames[f].image == ball_on(true).find("train")->frames[f].image);
  }

  TEST_CASE("pictures whose borders differ have no ground") {
    Dataset data = ball_on(true);
    Split& train = *data.find("train");
    CHECK(find_ground(train));
    for (std::size_t f = 0; f < train.frames.size(); ++f) {
      Image16 image = train.frames[f].image.unpacked();
      for (std::size_t i = 0; i < image.rgba.size(); i += 4)  // another wall in every picture
        for (std::size_t c = 0; c < 3; ++c)
          image.rgba[i + c] = std::uint16_t(257 * ((image.rgba[i + c] / 257 + 9 * f) % 256));
      train.frames[f].image = Picture(std::move(image));
    }
    CHECK_FALSE(find_ground(train));
  }

  TEST_CASE("prepared, the ground is the background; a second time and after loading again it is the same") {
    Dataset data = ball_on(true);
    const Prepared ready = prepared(test::small_run(100), data);
    CHECK(data.has_alpha);
    REQUIRE(data.ground);
    CHECK(ready.config.sampling.background == BackgroundKind::ground);
    CHECK(ready.config.run.background == std::vector<float>{data.ground->x, data.ground->y, data.ground->z});
    CHECK(ready.config.run.background_order == -1);
    CHECK(ready.notes.at(0).find("the pictures stand on a plain ground of") == 0);
    CHECK(write_config(prepared(ready.config, data).config) == write_config(ready.config));
    CHECK(write_config(prepared(test::small_run(100), data).config) == write_config(ready.config));
    Dataset again = ball_on(true);
    cut_ground(ready.config, again);
    for (std::size_t f = 0; f < 24; ++f)
      CHECK(again.find("train")->frames[f].image == data.find("train")->frames[f].image);
    Trainer one(ready.config, *data.find("train"), data.time_map),
        other(ready.config, *again.find("train"), again.time_map);
    CHECK(one.step().loss == other.step().loss);
  }

  TEST_CASE("who does not want it keeps opaque pictures; pictures with alpha keep theirs") {
    Config config = test::small_run(100);
    config.run.find_ground = false;
    Dataset data = ball_on(true);
    CHECK(write_config(prepared(config, data).config) == write_config(config));
    CHECK_FALSE(data.has_alpha);
    Dataset alpha = ball_on(false);
    config.sampling.background = BackgroundKind::ground;
    CHECK(prepared(config, alpha).config.sampling.background == BackgroundKind::random);
    CHECK_FALSE(alpha.ground);
  }

  TEST_CASE("a colour that is named and is not there cuts nothing, and stays behind opaque pixels") {
    Config config = test::small_run(100);
    config.sampling.background = BackgroundKind::ground;
    config.run.background = {1, 0, 1};
    Dataset data = ball_on(true);
    const Prepared ready = prepared(config, data);
    CHECK_FALSE(data.has_alpha);
    CHECK(ready.config.run.background == config.run.background);
    CHECK(ready.config.sampling.background == BackgroundKind::ground);
  }
}

TEST_SUITE("train/check_cameras") {
  TEST_CASE("silhouettes of the right cameras meet; other axes and the other direction are named") {
    Dataset data = ball_on(false);
    Split& train = *data.find("train");
    CHECK(explained_by_hull(train, cameras_of(train)) > 0.98);
    CHECK(notes_of([&](const auto& note) { check_silhouettes(train, note); }).empty());
    const Split right = train;
    const auto error_with = [&](std::size_t way) {
      const std::vector<OtherCameras> others = other_cameras(right);
      for (std::size_t f = 0; f < train.frames.size(); ++f) train.frames[f].camera = others[way].cameras[f];
      std::string text;
      try {
        check_silhouettes(train, [](const std::string&) {});
      } catch (const Error& error) {
        CHECK(error.fault == Fault::input);
        text = error.what();
      }
      return text;
    };
    CHECK(error_with(0).find("it looks like camera to world with OpenCV's axes") != std::string::npos);
    CHECK(error_with(1).find("it looks like world to camera") != std::string::npos);
  }

  TEST_CASE("cameras that belong to other pictures are said") {
    Dataset data = ball_on(false);
    Split& train = *data.find("train");
    std::vector<Camera> cameras = cameras_of(train);
    for (std::size_t f = 0; f < cameras.size(); ++f) {  // looking past what is there
      Camera& c = train.frames[f].camera;
      c.axes = {c.axes[2], c.axes[1], -c.axes[0]};
      if (f % 2) std::swap(train.frames[f].camera.position.x, train.frames[f].camera.position.z);
    }
    const auto notes = notes_of([&](const auto& note) { check_silhouettes(train, note); });
    REQUIRE(notes.size() == 1);
    CHECK(notes[0].find("the cameras may not belong to the pictures") != std::string::npos);
  }

  TEST_CASE("depth is not determined by cameras in one place, and is by a ring of them") {
    Dataset data = ball_on(false);
    Split& train = *data.find("train");
    CHECK(check_parallax(test::small_run(100), train, [](const std::string&) {}) > 30);
    for (Frame& f : train.frames) f.camera = train.frames[0].camera;
    const auto notes =
        notes_of([&](const auto& note) { CHECK(check_parallax(test::small_run(100), train, note) == 0); });
    REQUIRE(notes.size() == 1);
    CHECK(notes[0].find("its depth is not determined") != std::string::npos);
  }

  TEST_CASE("a unit in which no model can be stored is refused before the first step") {
    for (const double scale : {1e-5, 1e9}) {
      Dataset data = ball_on(false);
      for (Frame& f : data.find("train")->frames) f.camera.position = scale * f.camera.position;
      CHECK_THROWS_WITH_AS(Trainer(test::small_run(100), *data.find("train"), data.time_map),
                           doctest::Contains("splinevox convert DATASET --out NEW --scale="), Error);
    }
  }
}
