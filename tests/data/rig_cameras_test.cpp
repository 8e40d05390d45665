// SPDX-License-Identifier: Apache-2.0
#include "data/rig_cameras.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>

#include "data/expect_error.hpp"
#include "data/times/seen_moments.hpp"

using namespace splinevox;
using namespace splinevox::data;

namespace {

RawFrame frame(const std::string& path, double place, double time, const std::string& camera = "") {
  RawFrame f;
  f.file_path = path;
  f.time = time;
  f.matrix = {1, 0, 0, place, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  f.lens.fl_x = 100;
  f.camera = camera;
  return f;
}

std::vector<RawSplit> scene(std::vector<RawFrame> train, std::vector<RawFrame> test = {}) {
  return {{"train", "file", true, std::move(train)}, {"test", "file", true, std::move(test)}};
}

/// One list of the pictures that cam0, cam1 ... took at the same moments.
RawScene rig_of(int cameras, int moments) {
  std::vector<RawFrame> frames;
  for (int i = 0; i < moments; ++i)
    for (int c = 0; c < cameras; ++c) {
      const std::string name = "cam" + std::to_string(c);
      frames.push_back(frame(name + "/" + std::to_string(100 + i) + ".png", c, i, name));
    }
  RawScene rig;
  rig.splits = {{"train", "file", true, std::move(frames)}};
  rig.one_list = true;
  rig.cameras = settle_cameras(rig.splits);
  return rig;
}

}  // namespace

TEST_SUITE("data/rig_cameras") {
  TEST_CASE("frames of one pose are of one camera, named after their folder, in all splits") {
    auto splits =
        scene({frame("left/1.png", 0, 0), frame("right/images/1.png", 1, 0), frame("left/2.png", 0, 1)},
              {frame("right/images/2.png", 1, 1)});
    const auto cameras = settle_cameras(splits);
    REQUIRE(cameras.size() == 2);
    CHECK(cameras[0].name == "left");
    CHECK(cameras[1].name == "right");
    CHECK(cameras[1].still);
    CHECK(splits[0].frames[2].camera_id == 0);
    CHECK(splits[1].frames[0].camera_id == 1);
  }

  TEST_CASE("a folder that two cameras share names neither") {
    auto splits =
        scene({frame("images/1.png", 0, 0), frame("images/2.png", 0, 1), frame("images/3.png", 1, 1)});
    const auto cameras = settle_cameras(splits);
    REQUIRE(cameras.size() == 2);
    CHECK(cameras[0].name == "camera 0");
    CHECK(cameras[0].still);
    CHECK_FALSE(cameras[1].still);  // one frame proves nothing
  }

  TEST_CASE("names come before poses: a named camera may move") {
    auto splits = scene({frame("1.png", 0, 0, "a"), frame("2.png", 0.5, 1, "a"), frame("3.png", 2, 0, "b"),
                         frame("4.png", 2, 1, "b")});
    const auto cameras = settle_cameras(splits);
    REQUIRE(cameras.size() == 2);
    CHECK_FALSE(cameras[0].still);
    CHECK(cameras[1].still);
  }

  TEST_CASE("names that are of lenses or of single pictures are no cameras' names: poses tell") {
    for (const bool of_lenses : {true, false}) {
      CAPTURE(of_lenses);
      std::vector<RawFrame> frames;
      for (int t = 0; t < 5; ++t)
        for (int c = 0; c < 6; ++c) {
          const std::string file = std::to_string(100 * c + t);
          frames.push_back(
              frame("c" + std::to_string(c) + "/" + file + ".png", c, t, of_lenses ? "1" : file));
        }
      auto splits = scene(frames);
      const auto cameras = settle_cameras(splits);
      REQUIRE(cameras.size() == 6);
      CHECK(cameras[2].name == "c2");
      CHECK(std::all_of(cameras.begin(), cameras.end(), [](const RigCamera& c) { return c.still; }));
    }
  }

  TEST_CASE("one camera that is elsewhere every time, or one moment only, is no rig") {
    auto film = scene({frame("1.png", 0, 0), frame("2.png", 0.1, 1), frame("3.png", 0.2, 2)});
    CHECK(settle_cameras(film).empty());
    CHECK(film[0].frames[1].camera_id == -1);
    auto moment = scene({frame("1.png", 0, 0), frame("2.png", 0.1, 0), frame("3.png", 0.1, 0)});
    CHECK(settle_cameras(moment).empty());
  }

  TEST_CASE("a way that closes is no rig, one camera that stands beside one that moves is") {
    std::vector<RawFrame> way, beside;
    for (int i = 0; i < 12; ++i) {
      way.push_back(frame("r_" + std::to_string(i) + ".png", i % 11, i));
      beside.push_back(frame("s_" + std::to_string(i) + ".png", i % 3 ? i : 0, i));
    }
    auto closed = scene(way);
    CHECK(settle_cameras(closed).empty());
    auto mixed = scene(beside);
    const auto cameras = settle_cameras(mixed);
    REQUIRE(cameras.size() == 9);
    CHECK(cameras[0].still);
    for (RawFrame& f : way) f.camera = f.file_path == "r_11.png" ? "r_0.png" : f.file_path;
    auto named = scene(way);
    CHECK(settle_cameras(named).size() == 11);
  }

  TEST_CASE("films with time stamps of their own are of the same moments, cameras that take turns are not") {
    const auto shares = [](int cameras, double apart) {
      std::vector<std::set<double>> seen(static_cast<std::size_t>(cameras));
      std::set<double> moments;
      for (int c = 0; c < cameras; ++c)
        for (int i = 0; i < 40; ++i) {
          seen[std::size_t(c)].insert(i + c * apart);
          moments.insert(i + c * apart);
        }
      const auto each = shares_of_moments(seen, moments);
      return std::pair(*std::min_element(each.begin(), each.end()), scene_moments(seen, moments).size());
    };
    CHECK(shares(6, 0) == std::pair(1.0, std::size_t(40)));
    CHECK(shares(6, 0.04) == std::pair(1.0, std::size_t(40)));
    for (const int cameras : {2, 3, 6, 8, 12}) {
      CAPTURE(cameras);
      CHECK(shares(cameras, 1.0 / cameras).first < 0.75);
      CHECK(shares(cameras, 1.0 / cameras).second == std::size_t(40 * cameras));
    }
    CHECK(shares_of_moments({{0, 1, 2, 4, 5}, {0, 1, 2, 3, 4, 5}}, {0, 1, 2, 3, 4, 5})[0] ==
          doctest::Approx(5.0 / 6));
    CHECK(shares_of_moments({{0}, {}}, {0}) == std::vector<double>{1, 0});
    CHECK(shares_of_moments({}, {}).empty());
  }

  TEST_CASE("a rig of films whose stamps differ a little loses a whole camera") {
    std::vector<RawFrame> frames;
    for (int i = 0; i < 20; ++i)
      for (int c = 0; c < 6; ++c)
        frames.push_back(frame("cam" + std::to_string(c) + "/" + std::to_string(i) + ".png", c,
                               i * (1 + 1e-3 * c) + 0.03 * c, "cam" + std::to_string(c)));
    auto splits = scene(frames);
    const auto cameras = settle_cameras(splits);
    for (RawFrame& f : splits[0].frames) f.pose.position = {f.matrix[3], 0, 0};
    CHECK(cameras_to_hold_out(splits[0], cameras).size() == 1);
  }

  TEST_CASE("of few cameras each gives pictures to the test split in its turn") {
    for (const int cameras : {2, 4}) {
      CAPTURE(cameras);
      RawScene raw = rig_of(cameras, 40);
      hold_out(raw, "");
      REQUIRE(raw.splits.size() == 2);
      std::map<std::string, int> held_out;
      for (const RawFrame& f : raw.splits[1].frames) ++held_out[f.camera];
      REQUIRE(int(held_out.size()) == cameras);
      for (const auto& [name, count] : held_out) CHECK(count == 5);
    }
  }

  TEST_CASE("what is held out can be said: nothing, or cameras by their names") {
    RawScene all = rig_of(6, 8);
    hold_out(all, "none");
    REQUIRE(all.splits.size() == 1);
    CHECK(all.splits[0].frames.size() == 48);
    CHECK(all.notes == std::vector<std::string>{"nothing is held out: all pictures train"});

    RawScene some = rig_of(6, 8);
    hold_out(some, "cam5,cam1,cam5");
    REQUIRE(some.splits.size() == 2);
    CHECK(some.splits[0].frames.size() == 32);
    std::set<std::string> held_out;
    for (const RawFrame& f : some.splits[1].frames) held_out.insert(f.camera);
    CHECK(held_out == std::set<std::string>{"cam1", "cam5"});
    CHECK(some.notes ==
          std::vector<std::string>{"2 of 6 cameras are held out: 'cam1', 'cam5'; pictures: 16 in all"});
  }

  TEST_CASE("of a picture that is listed twice neither copy trains while the other is held out") {
    RawScene film;
    std::vector<RawFrame> frames;
    for (int i = 0; i < 24; ++i)
      for (int copy = 0; copy < 2; ++copy) frames.push_back(frame(std::to_string(100 + i) + ".png", i, i));
    film.splits = {{"train", "file", true, std::move(frames)}};
    film.one_list = true;
    hold_out(film, "");
    REQUIRE(film.splits.size() == 2);
    CHECK(film.splits[0].frames.size() == 21);
    CHECK(film.splits[1].frames.size() == 3);
    for (const RawFrame& a : film.splits[0].frames)
      for (const RawFrame& b : film.splits[1].frames) CHECK(a.file_path != b.file_path);
  }

  TEST_CASE("a camera that is not there, and all of them, cannot be held out") {
    for (const std::string bad : {"cam7", "cam1,,cam2", "cam1, cam2", " "}) {
      CAPTURE(bad);
      RawScene raw = rig_of(3, 4);
      test::expect_error([&] { hold_out(raw, bad); },
                         {"--hold-out", "there is no such camera", "none, or 'cam0', 'cam1', 'cam2'"});
    }
    RawScene raw = rig_of(3, 4);
    test::expect_error([&] { hold_out(raw, "cam0,cam1,cam2"); },
                       {"--hold-out", "no camera is left", "some of 'cam0', 'cam1', 'cam2'"});
    RawScene film;
    film.splits = {{"train", "file", true, {frame("0.png", 0, 0, ""), frame("1.png", 1, 1, "")}}};
    film.one_list = true;
    film.cameras = settle_cameras(film.splits);
    test::expect_error([&] { hold_out(film, "cam0"); }, {"--hold-out", "the data has no cameras"});
  }
}
