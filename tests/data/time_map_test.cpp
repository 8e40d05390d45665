// SPDX-License-Identifier: Apache-2.0
#include "data/times/time_map.hpp"

#include <doctest/doctest.h>

#include "data/expect_error.hpp"
#include "data/timed_split.hpp"
#include "data/times/settle.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::data;
using test::split_of;
using Notes = std::vector<std::string>;

TEST_SUITE("data/time_map") {
  TEST_CASE("times within [0, 1] are taken as they are, even if they do not fill it") {
    CHECK(fit_time_map({0, 0.5, 1}) == TimeMap{});
    CHECK(fit_time_map({0.2, 0.9}) == TimeMap{});
  }

  TEST_CASE("any other range is mapped onto [0, 1], ends exactly") {
    const TimeMap map = fit_time_map({30, 10, 17, 1e3});
    CHECK(map(10) == 0);
    CHECK(map(1e3) == 1);
    CHECK(map(505) == doctest::Approx(0.5));
    CHECK(fit_time_map({-1, 1})(0) == 0.5);
    for (double hi : {3.0, 7.0, 49.0, 299.0, 1e-3 + 1}) CHECK(fit_time_map({0, hi})(hi) <= 1);
  }

  TEST_CASE("one common time gives scale 0, wherever it lies") {
    CHECK(fit_time_map({0.5, 0.5}) == TimeMap{0.5, 0});
    CHECK(fit_time_map({77}) == TimeMap{77, 0});
    CHECK(fit_time_map({5, 5 + 1e-10})(1e9) == 0);
  }

  TEST_CASE("the train split's map serves the others and is noted") {
    Notes notes;
    const RawSplit train = split_of("train", {10, 20}), test = split_of("test", {15, 25});
    const TimeMap map = choose_time_map(&train, {train, test}, notes);
    CHECK(model_time(test, 0, map) == 0.5);
    CHECK(model_time(test, 1, map) == 1.5);
    REQUIRE(notes.size() == 1);
    CHECK(notes[0] == "train: times from 10 to 20 are mapped to 0 to 1, in every split");
  }

  TEST_CASE("times within a small part of [0, 1] are mapped onto all of it") {
    CHECK(fit_time_map({0.4, 0.45})(0.45) == doctest::Approx(1));
    CHECK(fit_time_map({0.4, 0.45})(0.4) == 0);
  }

  TEST_CASE("without a train split, times must lie in [0, 1]") {
    Notes notes;
    CHECK(choose_time_map(nullptr, {split_of("test", {0, 1})}, notes) == TimeMap{});
    CHECK(notes.size() == 1);
    test::expect_error(
        [&] {
          choose_time_map(nullptr, {split_of("test", {0, 1.5})}, notes);
        },
        {"s/transforms_test.json, frame 1: 'time' is outside [0, 1]", "got:      1.5",
         "add transforms_train.json"});
  }

  TEST_CASE("what is odd about times is noted, what is not is not") {
    Notes notes;
    note_times(split_of("val", {0, 0.5, 1}), {}, notes);
    CHECK(notes.empty());
    note_times(split_of("val", {0.5, 0, 0.5, 2}), {}, notes);
    REQUIRE(notes.size() == 3);
    CHECK(notes[0] == "val: frames are not in the order of time");
    CHECK(notes[1] == "val: 1 of 4 frames lie outside the train split's times");
    CHECK(notes[2] == "val: 4 frames share 3 distinct times");
  }

  TEST_CASE("frames of a film follow each other in the order of names, too") {
    std::vector<RawSplit> splits{split_of("train", {0, 0, 0})};
    for (std::size_t i = 0; i < 3; ++i) {
      splits[0].frames[i].file_path = "film.mp4";
      splits[0].frames[i].film_frame = int(2 - i);
    }
    std::vector<std::string> notes;
    settle_times("s", parse_times("order"), splits, notes);
    CHECK(splits[0].frames[0].time == 1);
    CHECK(splits[0].frames[1].time == 0.5);
    CHECK(splits[0].frames[2].time == 0);
  }
}

}  // namespace
