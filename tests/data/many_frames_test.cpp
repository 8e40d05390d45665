// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <set>

#include "core/process.hpp"
#include "data/pictures/decode.hpp"
#include "data/pictures/pictures.hpp"

using namespace splinevox;
using namespace splinevox::data;

namespace {

/// A split of frames whose pictures have one name, as a file that names one picture again and again makes.
std::vector<std::string> names_of(std::size_t frames) {
  RawSplit raw{"train", "transforms_train.json", true, {}};
  raw.frames.resize(frames);
  PicturePlan plan;
  plan.paths.assign(frames, "/data/train/a.png");
  return frame_names(raw, plan);
}

}  // namespace

TEST_SUITE("data/many_frames") {
  TEST_CASE("frames of one picture have names of their own, numbered from 2") {
    CHECK(names_of(3) == std::vector<std::string>{"train_a", "train_a_2", "train_a_3"});
    const double begin = thread_seconds();
    const std::vector<std::string> names = names_of(100'000);
    CHECK(thread_seconds() - begin < 60);  // under a second; over 500 if each looked through all others
    CHECK(names.back() == "train_a_100000");
    CHECK(std::set<std::string>(names.begin(), names.end()).size() == 100'000);
  }

  TEST_CASE("a name that another frame has by itself is not given twice") {
    RawSplit raw{"train", "transforms_train.json", true, {}};
    PicturePlan plan;
    for (const char* name : {"b_2", "b", "b", "b_2", "b"}) {
      raw.frames.emplace_back();
      raw.frames.back().name = name;
      plan.paths.push_back("/data/x/y.png");
    }
    const std::vector<std::string> names = frame_names(raw, plan);
    CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  }

  TEST_CASE("what decoding needs counts the largest picture for every thread") {
    PicturePlan plan;
    plan.downscale = 4;
    plan.sizes = {{400, 300}, {4000, 3000}};
    plan.turns = {1, 1};
    plan.pixel_bytes = {6, 8};
    plan.real = {0, 0};
    const double small = 400 * 300, large = 4000 * 3000;
    CHECK(memory_for(plan, 1).kept == doctest::Approx((6 * small + 8 * large) / 16));
    CHECK(memory_for(plan, 1).passing == doctest::Approx(2 * 8 * large + 2 * 8 * large / 16));
    CHECK(memory_for(plan, 64).passing == doctest::Approx(64 * memory_for(plan, 1).passing));
    plan.downscale = 1;
    plan.pixel_bytes = {3, 4};
    CHECK(memory_for(plan, 64).kept == doctest::Approx(3 * small + 4 * large));
    CHECK(memory_for(plan, 1).passing == doctest::Approx(8 * large + 2 * 4 * large));
    plan.turns = {1, 6};  // a picture that is turned is there twice
    CHECK(memory_for(plan, 1).passing == doctest::Approx(2 * 8 * large + 2 * 4 * large));
  }
}
