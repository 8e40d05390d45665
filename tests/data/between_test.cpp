// SPDX-License-Identifier: Apache-2.0
#include "data/times/between.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "data/expect_error.hpp"
#include "data/timed_split.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/data/synth.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::data;
using test::expect_error;
using test::split_of;

TEST_SUITE("data/between") {
  TEST_CASE("a part of time is two numbers in order") {
    CHECK_FALSE(parse_between("").has_value());
    CHECK(parse_between("-1.5:2e3")->from == -1.5);
    CHECK(parse_between("-1.5:2e3")->to == 2000);
    for (const char* bad : {"1", ":", "1:", ":2", "1:2:3", "a:b", "1 :2", "nan:1", "0:inf"}) {
      CAPTURE(bad);
      expect_error([&] { parse_between(bad); }, {"--between", "no part of time", "FROM:TO", bad});
    }
    for (const char* bad : {"2:1", "1:1"})
      expect_error([&] { parse_between(bad); }, {"--between", "ends before it begins", bad});
  }

  TEST_CASE("frames at both ends stay; a split without any goes, unless it is asked for") {
    const std::vector<RawSplit> all{split_of("train", {0, 0.25, 0.3, 0.5, 0.6}), split_of("val", {0.5, 1}),
                                    split_of("test", {0.9})};
    std::vector<RawSplit> splits = all;
    std::vector<std::string> notes;
    keep_between({0.25, 0.5}, {}, splits, notes);
    REQUIRE(splits.size() == 2);
    CHECK(splits[0].frames.size() == 3);
    CHECK(splits[1].frames.size() == 1);
    CHECK(notes == std::vector<std::string>{"train: 3 of 5 frames lie between 0.25 and 0.5",
                                            "val: 1 of 2 frames lie between 0.25 and 0.5",
                                            "test: 0 of 1 frames lie between 0.25 and 0.5"});
    splits = all;
    expect_error(
        [&] {
          keep_between({0.25, 0.5}, {"train", "test"}, splits, notes);
        },
        {"s/transforms_test.json", "--between", "times from 0.9 to 0.9", "0.25:0.5"});
    splits = all;
    expect_error(
        [&] {
          keep_between({2, 3}, {}, splits, notes);
        },
        {"s/transforms_train.json", "times from 0 to 0.6", "2:3"});
  }

  TEST_CASE("the part becomes [0, 1], whatever share of the data's time it is") {
    const test::TempFolder folder;
    SynthOptions small;
    small.frames = 12;
    small.size = 16;
    write_synth("toy", folder.str(), small);
    const Dataset all = load_dataset(folder.str());
    for (const char* part : {"0.2:0.9", "0.4:0.6"}) {
      CAPTURE(part);
      LoadOptions options;
      options.rules.between = part;
      const Dataset data = load_dataset(folder.str(), options);
      const Between between = *parse_between(part);
      std::vector<double> times, expected;
      for (const Frame& f : data.find("train")->frames) times.push_back(f.time);
      for (const Frame& f : all.find("train")->frames)
        if (f.time >= between.from && f.time <= between.to) expected.push_back(f.time);
      REQUIRE(times.size() == expected.size());
      REQUIRE(times.size() >= 2);
      CHECK(*std::min_element(times.begin(), times.end()) == 0);
      CHECK(*std::max_element(times.begin(), times.end()) == 1);
      for (std::size_t i = 0; i < times.size(); ++i)
        CHECK(data.time_map.raw(times[i]) == doctest::Approx(expected[i]));
      CHECK(data.fingerprint != all.fingerprint);
      const test::TempFolder out;
      convert_dataset(folder.str(), out.str() + "/part", {}, {.rules = {.between = part}});
      const Dataset converted = load_dataset(out.str() + "/part");
      for (std::size_t i = 0; i < times.size(); ++i)
        CHECK(converted.find("train")->frames[i].time == doctest::Approx(times[i]));
    }
  }
}
