// SPDX-License-Identifier: Apache-2.0
#include "train/effects/halves.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include "train/by_time.hpp"
#include "train/learn_cameras.hpp"

using namespace splinevox;

namespace {

/// Frames of a rig whose cameras all see every moment, moment after moment.
Split rig(int cameras, int moments) {
  Split out{"train", {}};
  for (int t = 0; t < moments; ++t)
    for (int c = 0; c < cameras; ++c) {
      Frame f;
      f.name = std::to_string(c) + "_" + std::to_string(t);
      f.camera.width = f.camera.height = 4;
      f.camera.fx = f.camera.fy = 4;
      f.camera.position = {double(c), 0, 0};
      f.time = moments > 1 ? double(t) / (moments - 1) : 0;
      f.image = Image16{4, 4, std::vector<std::uint16_t>(64, 65535)};
      f.camera_id = c;
      out.frames.push_back(std::move(f));
    }
  return out;
}

std::size_t cameras_in(const Split& split) {
  std::set<int> ids;
  for (const Frame& f : split.frames) ids.insert(f.camera_id);
  return ids.size();
}

}  // namespace

TEST_SUITE("train/halves") {
  TEST_CASE("pictures of a rig for the fits are of all of its cameras, also where moments divide evenly") {
    for (const auto& [cameras, moments] : {std::pair{10, 60}, {12, 60}, {12, 100}, {20, 120}, {8, 24}}) {
      CAPTURE(cameras);
      CAPTURE(moments);
      const Split train = rig(cameras, moments);
      const Halves halves = divide(train, {frames_by_time(train)});
      CHECK(halves.held_out.frames.size() == 20);
      CHECK(halves.fitted.frames.size() == 60);
      CHECK(cameras_in(halves.held_out) == std::size_t(cameras));
      CHECK(cameras_in(halves.fitted) == std::size_t(cameras));

      const Halves apart = divide_cameras(train);
      CHECK(cameras_in(apart.held_out) == std::size_t(cameras) / 5);
      CHECK(cameras_in(apart.fitted) == std::size_t(cameras - cameras / 5));
    }
  }

  TEST_CASE("of many cameras each has the three moments that a gain takes; of very many some") {
    for (const auto& [cameras, moments, kept] : {std::tuple{24, 12, 24}, {36, 8, 36}, {100, 10, 40}}) {
      CAPTURE(cameras);
      const Split train = rig(cameras, moments);
      const Halves halves = divide(train, {frames_by_time(train)});
      CHECK(halves.held_out.frames.size() == 20);
      const CameraFits fits = rig_of(halves.fitted);
      REQUIRE_FALSE(fits.cameras.empty());
      CHECK(std::count_if(fits.cameras.begin(), fits.cameras.end(),
                          [](const CameraFit& c) { return c.trained; }) == kept);
      for (const Frame& f : halves.held_out.frames) CHECK(fits.knows(f.camera_id));
    }
  }

  TEST_CASE("films of a rig with time stamps of their own have as many moments as one of them") {
    Split train = rig(6, 100);
    for (Frame& f : train.frames) f.time += 0.002 * f.camera_id / 6;  // a fifth of an interval
    CHECK_FALSE(middle_stretch(train));
    train = rig(6, 300);
    for (Frame& f : train.frames) f.time += 0.0006 * f.camera_id / 6;
    const auto stretch = middle_stretch(train);
    REQUIRE(stretch);
    CHECK(stretch->length == doctest::Approx(79 / 299.0));
    CHECK(stretch->frames.size() >= 6 * 79);
    CHECK(stretch->frames.size() <= 6 * 81);
  }

  TEST_CASE("of a film every fifth picture is held out, at even distances") {
    Split film{"train", {}};
    for (int i = 0; i < 40; ++i) {
      film.frames.push_back(rig(1, 1).frames[0]);
      film.frames.back().camera_id = -1;
      film.frames.back().time = i / 39.0;
    }
    const Halves halves = divide(film, {frames_by_time(film)});
    CHECK(halves.held_out_frames == std::vector<int>{2, 7, 12, 17, 22, 27, 32, 37});
    CHECK(halves.fitted.frames.size() == 32);
  }
}
