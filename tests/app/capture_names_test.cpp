// SPDX-License-Identifier: Apache-2.0
// What `capture` reads in names: moments of pictures, masks, and what COLMAP may not be told.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/program.hpp"
#include "data/expect_error.hpp"
#include "run/capture/capture_stages.hpp"
#include "splinevox/data/image_io.hpp"

namespace {

namespace fs = std::filesystem;
using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

/// What is planned for pictures of these names, folders included, and the notes.
struct Planned {
  std::vector<CapturePlan> plans;
  std::vector<std::string> notes;
};

Planned plan_of(const TempFolder& folder, const std::vector<std::string>& names,
                const CaptureOptions& options = {}) {
  for (const std::string& name : names)
    write_png(folder.path() / "in" / name, flat_png(4, 4, {255, 255, 255, 255}));
  CaptureTalk talk(Talk::quiet, {});
  Planned planned;
  planned.plans = plan_capture(find_capture_input({folder.str() + "/in"}), options, talk);
  planned.notes = talk.notes();
  return planned;
}

/// Times of the frames that are taken, and the stems of their names.
std::vector<double> taken_times(const CapturePlan& plan) {
  std::vector<double> times;
  for (const FrameGroup& group : plan.groups) times.push_back(plan.times[std::size_t(group.first)]);
  return times;
}
std::string taken_names(const CapturePlan& plan) {
  std::string names;
  for (const FrameGroup& group : plan.groups)
    names += plan.camera.pictures[std::size_t(group.first)].stem().string() + " ";
  return names;
}

/// Pictures "FOLDER0003.png" of these numbers.
std::vector<std::string> numbered(const std::string& before, const std::vector<int>& numbers) {
  std::vector<std::string> names;
  for (const int number : numbers) {
    const std::string digits = std::to_string(number);
    names.push_back(before + std::string(4 - digits.size(), '0') + digits + ".png");
  }
  return names;
}
std::vector<std::string> both(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A grey JPEG of 8 x 16 that EXIF turns by a quarter: all numbers are 0, one bit each.
Bytes turned_jpeg() {
  const auto put = [](Bytes& out, std::uint8_t mark, const Bytes& body) {
    for (const int v : {0xff, int(mark), 0, int(body.size()) + 2}) out.push_back(std::uint8_t(v));
    out.insert(out.end(), body.begin(), body.end());
  };
  Bytes tables(65, 1), codes(18, 0), jpeg{0xff, 0xd8};
  tables[0] = 0;
  codes[1] = 1;  // the one code, of one bit
  put(jpeg, 0xe1, {'E',  'x',  'i', 'f', 0, 0, 'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1,
                   0x01, 0x12, 0,   3,   0, 0, 0,   1,   0, 6,  0, 0, 0, 0, 0, 0});
  put(jpeg, 0xdb, tables);
  put(jpeg, 0xc0, {8, 0, 16, 0, 8, 1, 1, 0x11, 0});
  put(jpeg, 0xc4, codes);
  codes[0] = 0x10;
  put(jpeg, 0xc4, codes);
  put(jpeg, 0xda, {1, 1, 0, 0, 63, 0});
  for (const int v : {0x0f, 0xff, 0xd9}) jpeg.push_back(std::uint8_t(v));  // two blocks of two numbers
  return jpeg;
}

using Times = std::vector<double>;

CaptureState state_of(const std::vector<std::string>& names, const std::vector<std::string>& rig = {}) {
  CaptureState state;
  state.rig = rig;
  for (const std::string& name : names) {
    const auto of = std::find(rig.begin(), rig.end(), name.substr(0, name.find('/')));
    state.frames.push_back({name, int(of - rig.begin()), 0, ""});
  }
  return state;
}

TEST_SUITE("app/capture names") {
  TEST_CASE("folders per camera: pictures of one name are of one moment, and a missing one is a gap") {
    CaptureOptions options;
    options.fps = 10;
    const std::vector<std::string> names = both(numbered("cam01/", {0, 1, 2, 4, 5, 6, 7, 8, 9}),
                                                numbered("cam02/", {0, 1, 2, 3, 5, 6, 7, 8, 9}));
    const TempFolder folder;
    const Planned all = plan_of(folder, names, options);
    REQUIRE(all.plans.size() == 2);
    CHECK(taken_times(all.plans[0]) == Times{0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9});
    CHECK(taken_times(all.plans[1]) == Times{0, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9});
    REQUIRE(all.notes.size() == 1);
    CHECK(contains(all.notes[0], "2 of 20, such as 'cam01/0003.png'"));

    options.every = 2;  // of each two that which both cameras saw
    const Planned half = plan_of(folder, {}, options);
    CHECK(taken_names(half.plans[0]) == "0000 0002 0005 0006 0008 ");
    CHECK(taken_names(half.plans[1]) == "0000 0002 0005 0006 0008 ");

    CaptureTalk talk(Talk::quiet, {});
    const std::vector<CaptureFrame> frames = write_capture_frames(all.plans, folder.path() / "out", talk);
    REQUIRE(frames.size() == 18);
    CHECK(frames[13].name == "cam02/0005.png");
    CHECK(frames[13].time == 0.5);
  }

  TEST_CASE("folders per camera: numbers behind the cameras' own words, and names without numbers") {
    const TempFolder words, letters;
    const Planned own =
        plan_of(words, both(numbered("left/left_", {1, 2, 3, 4}), numbered("right/right_", {1, 3, 4})));
    CHECK(taken_times(own.plans[0]) == Times{0, 1, 2, 3});
    CHECK(taken_times(own.plans[1]) == Times{0, 2, 3});
    const Planned plain =
        plan_of(letters, {"x/a.png", "x/b.png", "x/c.png", "x/d.png", "y/a.png", "y/c.png", "y/d.png"});
    CHECK(taken_times(plain.plans[0]) == Times{0, 1, 2, 3});
    CHECK(taken_times(plain.plans[1]) == Times{0, 2, 3});
    REQUIRE(plain.notes.size() == 1);
    CHECK(contains(plain.notes[0], "1 of 8, such as 'y/b.png'"));
  }

  TEST_CASE("folders per camera: names with nothing in common are paired by order; with a little, refused") {
    const TempFolder apart, overlapping;
    const Planned order =
        plan_of(apart, both(numbered("x/IMG_", {1234, 1235, 1236}), numbered("y/IMG_", {87, 88, 90})));
    CHECK(taken_times(order.plans[0]) == Times{0, 1, 2});
    CHECK(taken_times(order.plans[1]) == Times{0, 1, 2});
    REQUIRE(order.notes.size() == 1);
    CHECK(contains(order.notes[0], "no names of pictures in common"));
    expect_error(
        [&] {
          plan_of(overlapping,
                  both(numbered("x/IMG_", {1, 2, 3, 4, 5, 6}), numbered("y/IMG_", {6, 7, 8, 9, 10, 11})));
        },
        {"do not tell which cameras took at the same moment", "'IMG_0006.png' is in two folders", "rename"});
  }

  TEST_CASE("folders per camera: one without a picture of any moment that is taken is named") {
    const TempFolder folder;
    std::vector<std::string> names = numbered("cam4/", {1, 3, 5, 7});
    for (const char* camera : {"cam1/", "cam2/"}) names = both(names, numbered(camera, {0, 2, 4, 6}));
    names = both(names, numbered("cam3/", {0, 1, 2, 3, 4, 5, 6, 7}));
    CHECK(plan_of(folder, names).plans.size() == 4);
    CaptureOptions options;
    options.every = 2;
    expect_error(
        [&] { plan_of(folder, {}, options); },
        {"in, camera cam4: has no picture of any moment that is taken of the other cameras", "--every"});
  }

  TEST_CASE("folders per camera: one that stopped early has gaps at the end") {
    const TempFolder folder;
    const Planned early = plan_of(
        folder, both(numbered("cam01/", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}), numbered("cam02/", {0, 1, 2})));
    CHECK(taken_times(early.plans[0]).size() == 10);
    CHECK(taken_times(early.plans[1]) == Times{0, 1, 2});
    REQUIRE(early.notes.size() == 1);
    CHECK(contains(early.notes[0], "7 of 20, such as 'cam02/0003.png'"));
  }

  TEST_CASE("one folder: numbers that grow unevenly are times, those of photographs are not") {
    CaptureOptions options;
    options.fps = 2;
    const TempFolder uneven, even, photographs;
    const Planned gap = plan_of(uneven, numbered("", {10, 11, 13, 14}), options);
    CHECK(taken_times(gap.plans.at(0)) == Times{0, 0.5, 1.5, 2});
    REQUIRE(gap.notes.size() == 1);
    CHECK(contains(gap.notes[0], "1 of 3 times by another step than the usual"));
    const Planned fifth = plan_of(even, numbered("frame_", {0, 5, 10, 15}), options);
    CHECK(taken_times(fifth.plans.at(0)) == Times{0, 0.5, 1, 1.5});
    CHECK(fifth.notes.empty());
    const Planned taken = plan_of(photographs, numbered("IMG_", {10, 11, 13, 14}), options);
    CHECK(taken_times(taken.plans.at(0)) == Times{0, 0.5, 1, 1.5});
    CHECK(taken.notes.empty());
  }

  TEST_CASE("dynamic_mask_NAME keeps its name in the data set, whatever its case") {
    for (const std::string name : {"dynamic_mask_a.png", "Dynamic_mask_a.png", "DYNAMIC_MASK_a.png"}) {
      CAPTURE(name);
      const TempFolder folder;
      const Planned planned = plan_of(folder, {"a.png", "b.png", "c.png", name});
      CaptureTalk talk(Talk::quiet, {});
      const std::vector<CaptureFrame> frames =
          write_capture_frames(planned.plans, folder.path() / "out", talk);
      REQUIRE(frames.size() == 3);
      CHECK(frames[0].mask == "masks/dynamic_mask_a.png");
      CHECK(fs::exists(folder.path() / "out/masks/dynamic_mask_a.png"));
    }
  }

  TEST_CASE(
      "pictures whose names differ in the ending alone all stay, turned ones too, and so do their masks") {
    const TempFolder folder;
    for (const char* name : {"in/a.jpg", "in/b.jpg"}) write_bytes(folder.path() / name, turned_jpeg());
    for (const char* name : {"in/a.png", "in/masks/a.png"})
      write_png(folder.path() / name, flat_png(16, 8, {255, 255, 255, 255}));
    CaptureTalk talk(Talk::quiet, {});
    const fs::path out = folder.path() / "out";
    const std::vector<CaptureFrame> frames = write_capture_frames(plan_of(folder, {}).plans, out, talk);
    REQUIRE(frames.size() == 3);
    CHECK(frames[0].name == "a.jpg.png");
    CHECK(frames[0].mask == "masks/a.jpg.png");
    CHECK(frames[1].name == "a.png");
    CHECK(frames[1].mask == "masks/a.png.png");
    CHECK(frames[2].name == "b.png");
    CHECK(frames[2].mask.empty());
    for (const CaptureFrame& frame : frames) {
      CAPTURE(frame.name);
      const Image16 picture = read_picture(out / "images" / frame.name);
      CHECK(picture.width == 16);
      CHECK(picture.height == 8);
      CHECK(picture.rgba[0] == (frame.name == "a.png" ? 65535 : 128 * 257));
      CHECK((frame.mask.empty() || fs::exists(out / frame.mask)));
      CHECK(fs::exists(out / "work/masks" / (frame.name + ".png")) == !frame.mask.empty());
    }
  }

  TEST_CASE("COLMAP knows frames by numbers where it would misread their names, and gives the names back") {
    CHECK(!needs_numbers(state_of({"1.png", "2.png", "3.png"})));
    CHECK(needs_numbers(state_of({"1.png", "2.png", "10.png"})));  // in another order than that of characters
    CHECK(!needs_numbers(state_of({"b/1.png", "b/2.png", "b/10.png", "a/1.png"}, {"b", "a"})));
    CHECK(needs_numbers(state_of({"1.png", "2 (1).png"})));
    CHECK(needs_numbers(state_of({"#1.png", "#2.png"})));

    CaptureState state =
        state_of({"cam #1/a 1.png", "cam #1/a 2.JPG", "b/1.png", "walk/000000.png"}, {"cam #1", "b"});
    CHECK(needs_numbers(state));
    CHECK(colmap_name(state, 1) == "cam #1/a 2.JPG");
    state.numbered = true;
    data::ColmapModel model;
    for (std::size_t i = 0; i < state.frames.size(); ++i)
      model.images.push_back({{}, {}, 1, colmap_name(state, i)});
    CHECK(model.images[1].name == "000/000001.JPG");
    CHECK(model.images[2].name == "001/000002.png");
    CHECK(model.images[3].name == "002/000003.png");
    name_frames(model, state);
    for (std::size_t i = 0; i < state.frames.size(); ++i) CHECK(model.images[i].name == state.frames[i].name);

    state = state_of({"1.png", "2.png", "10.png"});
    state.numbered = true;
    CHECK(colmap_name(state, 2) == "000002.png");
    const TempFolder folder;
    fs::create_directories(folder.path() / "work");
    write_capture_state(folder.path(), state);
    CHECK(read_capture_state(folder.path()).numbered);
  }
}

}  // namespace
