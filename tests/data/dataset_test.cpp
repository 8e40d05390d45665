// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "data/expect_error.hpp"
#include "math/camera.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;

bool noted(const Dataset& dataset, const std::string& part) {
  return std::any_of(dataset.notes.begin(), dataset.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

/// One split with a 2 x 2 picture per frame at the given times ("" = no time).
void write_split(const TempFolder& folder, const std::string& split, const std::vector<std::string>& times,
                 std::array<std::uint8_t, 4> rgba = {200, 100, 50, 255}) {
  std::vector<std::string> frames;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::string file = split + "/r_" + std::to_string(i);
    write_png(folder.path() / (file + ".png"), flat_png(2, 2, rgba));
    frames.push_back(frame_text(file, times[i], matrix_text(orbit_matrix(double(i)))));
  }
  write_text(folder.path() / ("transforms_" + split + ".json"), transforms_text(frames));
}

/// Text as it stands in a JSON file.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    char code[8];
    std::snprintf(code, sizeof code, "\\u%04x", unsigned(static_cast<unsigned char>(c)));
    if (static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\')
      out += code;
    else
      out += c;
  }
  return out;
}

TEST_SUITE("data/dataset") {
  TEST_CASE("a whole data set comes in: splits in order, names, times, cameras, pixels") {
    const TempFolder folder;
    write_moving_ball(folder.path());
    const Dataset dataset = load_dataset(folder.str());
    REQUIRE(dataset.splits.size() == 3);
    CHECK(dataset.splits[0].name == "train");
    CHECK(dataset.splits[1].name == "val");
    CHECK(dataset.splits[2].name == "test");
    CHECK(dataset.path == folder.str());
    CHECK(dataset.time_map == TimeMap{});
    CHECK(dataset.has_alpha);
    CHECK(dataset.notes.empty());
    const Split& train = *dataset.find("train");
    REQUIRE(train.frames.size() == 8);
    CHECK(train.frames[3].name == "r_3");
    CHECK(train.frames[7].time == 1);
    CHECK(train.frames[0].camera.width == 16);
    CHECK(train.frames[0].camera.fx == doctest::Approx(8 / std::tan(0.4)));
    CHECK(dataset.find("nothing") == nullptr);
  }

  TEST_CASE("cameras and pictures fit together: the ball is where its centre projects to") {
    const TempFolder folder;
    write_moving_ball(folder.path(), {.train = 6, .val = 0, .test = 0, .size = 48});
    const Dataset dataset = load_dataset(folder.str());
    for (const Frame& frame : dataset.splits[0].frames) {
      const Projection p = project(frame.camera, {-0.4 + 0.8 * frame.time, 0, 0});
      CAPTURE(frame.name);
      CHECK(p.depth > 2);
      CHECK(frame.image.pixel(int(p.u), int(p.v))[3] == 65535);
      double x = 0, y = 0, n = 0;
      for (int j = 0; j < 48; ++j)
        for (int i = 0; i < 48; ++i)
          if (frame.image.pixel(i, j)[3] > 0) {
            x += i + 0.5;
            y += j + 0.5;
            n += 1;
          }
      CHECK(x / n == doctest::Approx(p.u).epsilon(0.03));
      CHECK(y / n == doctest::Approx(p.v).epsilon(0.03));
    }
  }

  TEST_CASE("only the splits asked for are read; the time map is still the train split's") {
    const TempFolder folder;
    write_split(folder, "train", {"10", "20"});
    write_split(folder, "test", {"15"});
    write_text(folder.path() / "train/r_0.png", "not looked at");
    const Dataset dataset = load_dataset(folder.str(), {.splits = {"test"}});
    REQUIRE(dataset.splits.size() == 1);
    CHECK(dataset.splits[0].frames[0].time == 0.5);
    CHECK(dataset.fingerprint == 0);
    CHECK_FALSE(dataset.has_alpha);
  }

  TEST_CASE("a run's time map beats the train split's, which need not be there") {
    const TempFolder folder;
    write_split(folder, "test", {"15", "25"});
    const Dataset dataset = load_dataset(folder.str(), {.time_map = TimeMap{10, 0.1}});
    CHECK(dataset.splits[0].frames[0].time == 0.5);
    CHECK(dataset.splits[0].frames[1].time == 1.5);
    CHECK(dataset.time_map == TimeMap{10, 0.1});
    CHECK(noted(dataset, "test: 1 of 2 frames lie outside the train split's times"));
  }

  TEST_CASE("without any time the numbers in the names are taken, and said; --times decides otherwise") {
    const TempFolder folder;
    write_split(folder, "train", {"", "", ""});
    const Dataset dataset = load_dataset(folder.str());
    CHECK(dataset.splits[0].frames[1].time == 0.5);
    CHECK(dataset.splits[0].frames[2].time == 1);
    CHECK(noted(dataset, "the data has no times, so they are those in the names"));
    const auto with = [&](const std::string& times) {
      return load_dataset(folder.str(), {.rules = {.times = times}});
    };
    CHECK(with("none").time_map.scale == 0);
    CHECK(noted(with("none"), "all pictures are of one moment (--times none)"));
    CHECK(with("order").splits[0].frames[1].time == 0.5);
    CHECK(with("name:-1").splits[0].frames[1].time == 0.5);
    write_text(folder.path() / "when.csv", "r_0,5\nr_1,6\nr_2,9\n");
    CHECK(with((folder.path() / "when.csv").string()).splits[0].frames[1].time == doctest::Approx(0.25));
    expect_error([&] { with("name:x"); }, {"--times: this is no group of digits", "'name:x'"});
    expect_error([&] { with("name:9"); }, {"this name has no such group of digits"});
    expect_error([&] { with("sometimes"); }, {"there is no such file, and no such source of times"});
  }

  TEST_CASE("a single frame has time 0 and nothing moves") {
    const TempFolder folder;
    write_split(folder, "train", {"0.7"});
    const Dataset dataset = load_dataset(folder.str());
    CHECK(dataset.splits[0].frames[0].time == 0);
    CHECK(dataset.time_map.scale == 0);
    CHECK(noted(dataset, "nothing can move"));
  }

  TEST_CASE("downscaling averages blocks and scales the lens") {
    const TempFolder folder;
    TinyPng png{2, 2, 8, PngKind::rgba, {0, 0, 0, 0, 100, 0, 0, 0, 0, 0, 0, 255, 100, 0, 0, 255}};
    write_png(folder.path() / "a.png", png);
    write_text(folder.path() / "transforms_train.json",
               transforms_text({frame_text("a.png", "0", matrix_text(orbit_matrix(0)))},
                               R"("fl_x": 3, "fl_y": 5, "cx": 1.5, "cy": 0.5, "w": 2, "h": 2,)"));
    const Dataset dataset = load_dataset(folder.str(), {.downscale = 2});
    const Frame& frame = dataset.splits[0].frames[0];
    CHECK(frame.image.width == 1);
    CHECK(frame.camera.width == 1);
    CHECK(frame.camera.fx == 1.5);
    CHECK(frame.camera.fy == 2.5);
    CHECK(frame.camera.cx == 0.75);
    CHECK(frame.camera.cy == 0.25);
    CHECK(frame.image.pixel(0, 0)[0] == 50 * 257);
    CHECK(frame.image.pixel(0, 0)[3] == 32768);
    CHECK(dataset.downscale == 2);
  }

  TEST_CASE("a ray through the same point of the picture is the same at every downscale") {
    const TempFolder folder;
    write_moving_ball(folder.path(), {.train = 2, .val = 0, .test = 0});
    const Camera full = load_dataset(folder.str()).splits[0].frames[1].camera;
    const Camera small = load_dataset(folder.str(), {.downscale = 4}).splits[0].frames[1].camera;
    const Ray a = camera_ray(full, 6, 10), b = camera_ray(small, 1.5, 2.5);
    CHECK(length(a.direction - b.direction) < 1e-14);
  }

  TEST_CASE("a frame's own lens overrides the file's") {
    const TempFolder folder;
    write_split(folder, "train", {"0", "1"});
    std::string own = frame_text("train/r_1", "1", matrix_text(orbit_matrix(1)));
    own.insert(1, "\"fl_x\": 7, \"cy\": 1.25, ");
    write_text(
        folder.path() / "transforms_train.json",
        transforms_text({frame_text("train/r_0", "0", matrix_text(orbit_matrix(0))), own}, "\"fl_x\": 3,"));
    const Split train = load_dataset(folder.str()).splits[0];
    CHECK(train.frames[0].camera.fx == 3);
    CHECK(train.frames[0].camera.cy == 1);
    CHECK(train.frames[1].camera.fx == 7);
    CHECK(train.frames[1].camera.cy == 1.25);
  }

  TEST_CASE("names of many kinds are found: with and without extension, dots, spaces, unicode, subfolders") {
    const TempFolder folder;
    const std::vector<std::string> names = {"a.png",    "./b",      "deep/er/c", "with space",
                                            "r.000.v2", "./x/../d", "grün",      "e.PNG"};
    std::vector<std::string> frames;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool has_end = names[i].ends_with(".png") || names[i].ends_with(".PNG");
      const std::string file = names[i] == "./x/../d" ? "d" : names[i];
      write_png(folder.path() / (has_end ? file : file + ".png"), flat_png(2, 2));
      frames.push_back(frame_text(names[i], std::to_string(i), matrix_text(orbit_matrix(0))));
    }
    write_text(folder.path() / "transforms_train.json", transforms_text(frames));
    const Dataset dataset = load_dataset(folder.str());
    std::vector<std::string> found;
    for (const Frame& frame : dataset.splits[0].frames) found.push_back(frame.name);
    CHECK(found == std::vector<std::string>{"a", "b", "c", "with space", "r.000.v2", "d", "grün", "e"});
  }

  TEST_CASE("a frame's name holds letters, digits, dots, dashes and blanks, whatever its picture is called") {
    const TempFolder folder;
    const std::vector<std::pair<std::string, std::string>> names = {{"$(touch x)", "__touch x_"},
                                                                    {"a;b&c|d", "a_b_c_d"},
                                                                    {"`id`", "_id_"},
                                                                    {"it's\"q\"", "it_s_q_"},
                                                                    {"-rf", "_-rf"},
                                                                    {"line\nfeed", "line_feed"},
                                                                    {"=1+1", "_1_1"},
                                                                    {"a\xe2\x80\xae"
                                                                     "b",
                                                                     "a_b"},
                                                                    {"esc\x1b[31m", "esc__31m"},
                                                                    {"漢字 7", "漢字 7"},
                                                                    {"é.x_y-z", "é.x_y-z"},
                                                                    {"c,d", "c_d"},
                                                                    {"a b\xc2\xa0"
                                                                     "c",
                                                                     "a b_c"},
                                                                    {"<b>", "_b_"}};
    std::vector<std::string> frames;
    for (std::size_t i = 0; i < names.size(); ++i) {
      write_png(folder.path() / (names[i].first + ".png"), flat_png(2, 2));
      frames.push_back(frame_text(escaped(names[i].first), std::to_string(i), matrix_text(orbit_matrix(0))));
    }
    write_text(folder.path() / "transforms_train.json", transforms_text(frames));
    const Dataset dataset = load_dataset(folder.str());
    REQUIRE(dataset.splits[0].frames.size() == names.size());
    for (std::size_t i = 0; i < names.size(); ++i) CHECK(dataset.splits[0].frames[i].name == names[i].second);
  }

  TEST_CASE("a byte-order mark, and a folder reached through a link, do no harm") {
    const TempFolder folder;
    write_split(folder, "train", {"0", "1"});
    const auto json = folder.path() / "transforms_train.json";
    write_text(
        json, "\xef\xbb\xbf" + transforms_text({frame_text("train/r_0", "0", matrix_text(orbit_matrix(0)))}));
    const TempFolder other;
    std::filesystem::create_directory_symlink(folder.path(), other.path() / "link");
    CHECK(load_dataset((other.path() / "link").string()).splits[0].frames.size() == 1);
    CHECK(load_dataset(folder.str() + "/").splits[0].frames.size() == 1);
  }

  TEST_CASE("the fingerprint is that of poses, times and pixels, whatever the threads") {
    const TempFolder folder;
    write_moving_ball(folder.path());
    const std::uint64_t first = load_dataset(folder.str()).fingerprint;
    CHECK(first != 0);
    CHECK(load_dataset(folder.str(), {.splits = {"train"}}).fingerprint == first);
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      CHECK(load_dataset(folder.str()).fingerprint == first);
    }
    CHECK(load_dataset(folder.str(), {.downscale = 2}).fingerprint != first);
    write_moving_ball(folder.path(), {.angle_x = 0.81});
    CHECK(load_dataset(folder.str()).fingerprint != first);
    write_moving_ball(folder.path());
    CHECK(load_dataset(folder.str()).fingerprint == first);
    TinyPng changed = ball_png(16, 0.8, orbit_matrix(0), 0);
    changed.rows[5] ^= 1;
    write_png(folder.path() / "train/r_0.png", changed);
    CHECK(load_dataset(folder.str()).fingerprint != first);
  }

  TEST_CASE("what is odd about cameras and pictures is noted") {
    const TempFolder folder;
    write_split(folder, "train", {"0", "1"}, {0, 0, 0, 255});
    write_split(folder, "val", {"0"}, {9, 9, 9, 0});
    auto m = orbit_matrix(0);
    for (std::size_t i : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u}) m[i] *= 1.0005;
    write_png(folder.path() / "big.png", flat_png(4, 4));
    write_text(folder.path() / "transforms_test.json",
               transforms_text({frame_text("big", "0", matrix_text(m))}));
    const Dataset dataset = load_dataset(folder.str());
    CHECK(noted(dataset, "train: 2 of 2 pictures are wholly black, first r_0"));
    CHECK(noted(dataset, "val: 1 of 1 pictures are wholly transparent, first r_0"));
    CHECK(noted(dataset, "test: 1 of 1 camera matrices were off rigid by up to 0.0005"));
    CHECK(noted(dataset, "test: pictures of 4 x 4, train has 2 x 2"));
    CHECK_FALSE(dataset.has_alpha);
    for (const std::string& note : dataset.notes) CHECK(note.find('\n') == std::string::npos);
  }

  TEST_CASE("real data: D-NeRF's lego") {
    const char* root = std::getenv("SPLINEVOX_DATA");
    const std::string folder = root ? std::string(root) + "/dnerf_lego" : "";
    if (folder.empty() || !std::filesystem::exists(folder)) {
      MESSAGE("skipped: SPLINEVOX_DATA names no folder with dnerf_lego");
      CHECK(true);
      return;
    }
    const Dataset dataset = load_dataset(folder);
    REQUIRE(dataset.find("train") != nullptr);
    REQUIRE(dataset.find("test") != nullptr);
    CHECK(dataset.find("train")->frames.size() == 50);
    CHECK(dataset.find("test")->frames.size() == 20);
    CHECK(dataset.has_alpha);
    CHECK(dataset.time_map == TimeMap{});
    for (const Split& split : dataset.splits)
      for (const Frame& frame : split.frames) {
        CHECK(frame.image.width == 400);
        CHECK(frame.image.height == 400);
        CHECK(frame.time >= 0);
        CHECK(frame.time <= 1);
        CHECK(std::abs(length(frame.camera.position) - 4.031) < 0.01);
      }
  }
}

}  // namespace
