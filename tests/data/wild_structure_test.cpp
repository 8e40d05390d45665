// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "data/expect_error.hpp"
#include "data/wild.hpp"

/// What the structure trial of tests/torture found: sets that were read wrongly without a word.
namespace {

using namespace splinevox;
using namespace splinevox::test;

const TinyPng white = flat_png(kWide, kHigh, {255, 255, 255, 255});

TEST_SUITE("data/wild structure") {
  TEST_CASE("COLMAP: other models and pictures without a camera are counted") {
    const TempFolder folder;
    write_colmap_text(folder.path(), true_cameras({}, 10), ColmapLens{"PINHOLE", 1, {11, 11, 6, 4}});
    CHECK(notes_with(load_dataset(folder.str()), "camera in the model").empty());
    write_png(folder.path() / "images/frame_0010.png", flat_png(kWide, kHigh));
    write_png(folder.path() / "images/more/a.png", flat_png(kWide, kHigh));
    write_png(folder.path() / "images/masks/frame_0010.png", flat_png(kWide, kHigh));
    fs::copy(folder.path() / "sparse/0", folder.path() / "sparse/1");
    const Dataset data = load_dataset(folder.str());
    CHECK(frames_of(data) == 10);
    CHECK(notes_with(data, "2 of 12 pictures have no camera in the model, such as 'images/frame_0010.png'")
              .size() == 1);
    CHECK(notes_with(data, "'sparse/1'; sparse/0 is read alone").size() == 1);
  }

  TEST_CASE("lists and files that name a picture twice are noticed") {
    const TempFolder lists;
    write_nerfstudio(lists.path(), true_cameras({}, 5));
    replace_in(lists.path() / "transforms.json", "\"aabb_scale\"",
               "\"train_filenames\": [\"images/frame_0000.png\", \"images/frame_0004.png\"], "
               "\"test_filenames\": [\"images/frame_0002.png\", \"images/frame_0004.png\"], \"aabb_scale\"");
    const Dataset data = load_dataset(lists.str());
    CHECK(data.find("test")->frames.size() == 1);
    CHECK(notes_with(data, "1 names in the lists of val and test are in several lists").size() == 1);
    const TempFolder files;
    write_moving_ball(files.path());
    fs::copy_file(files.path() / "transforms_val.json", files.path() / "transforms_test.json",
                  fs::copy_options::overwrite_existing);
    CHECK(notes_with(load_dataset(files.str()),
                     "2 of 12 frames have a picture that another frame has, such as 'val/r_0' (val and test)")
              .size() == 1);
  }

  TEST_CASE("LLFF: rows go by letters; a note where people count otherwise") {
    const TempFolder folder;
    write_llff(folder.path(), true_cameras({}, 12));
    CHECK(notes_with(load_dataset(folder.str()), "order of letters").empty());
    for (int i = 0; i < 12; ++i)
      fs::rename(folder.path() / "images_4" / ("frame_" + padded(i) + ".png"),
                 folder.path() / "images_4" / ("frame_" + std::to_string(i) + ".png"));
    CHECK(notes_with(load_dataset(folder.str()), "rows are taken in the order of letters").size() == 1);
  }

  TEST_CASE("a mask whose picture is missing does not stand in for it") {
    for (const std::string form : {"dynamic_mask_NAME.png", "NAME.png.png", "NAME_mask.png"}) {
      CAPTURE(form);
      const TempFolder folder;
      write_llff(folder.path(), true_cameras({}, 8));
      for (int i = 0; i < 8; ++i) {
        std::string name = form;
        name.replace(name.find("NAME"), 4, "frame_" + padded(i));
        write_png(folder.path() / "images_4" / name, flat_png(kWide, kHigh));
      }
      CHECK(notes_with(load_dataset(folder.str()), "named as masks").empty());
      fs::remove(folder.path() / "images_4/frame_0003.png");
      expect_error([&] { load_dataset(folder.str()); },
                   {"not as many pictures as cameras", "8, one per row", "7"});
      for (int i = 0; i < 8; ++i) fs::remove(folder.path() / "images_4" / ("frame_" + padded(i) + ".png"));
      CHECK(notes_with(load_dataset(folder.str()), "are named as masks are").size() == 1);
    }
  }

  TEST_CASE("a rig's depth maps beside its pictures are no frames") {
    const TempFolder folder;
    write_rig(folder.path(), 3, 6,
              [](int c, int k) { return "cam0" + std::to_string(c) + "/" + padded(k) + ".png"; });
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 6; ++k)
        write_png(folder.path() / ("cam0" + std::to_string(c)) / (padded(k) + "_depth.png"),
                  flat_png(kWide, kHigh));
    expect_error([&] { load_dataset(folder.str()); },
                 {"'cam01/0000_depth.png' would be of one camera and one moment"});
  }

  TEST_CASE("times.txt: names with or without ending, for paths with or without") {
    const TempFolder folder;
    write_moving_ball(folder.path(), {.train = 6, .val = 0, .test = 0});
    replace_in(folder.path() / "transforms_train.json", "\"time\"", "\"timestamp\"");
    std::string lines;
    for (int i = 0; i < 6; ++i)
      lines.append(i % 2 ? "train/r_" : "./train/r_")
          .append(std::to_string(i))
          .append(i < 3 ? ".png " : " ")
          .append(std::to_string(10 * i * i) + "\n");
    write_text(folder.path() / "times.txt", lines);
    const Dataset data = load_dataset(folder.str());
    for (int i = 0; i < 6; ++i)
      CHECK(data.splits[0].frames[std::size_t(i)].time == doctest::Approx(i * i / 25.0));
    CHECK(notes_with(data, "'timestamp' is not read: call it 'time'").size() == 1);
  }

  TEST_CASE("a time by the name that another layout has is named") {
    const TempFolder folder;
    write_moving_ball(folder.path(), {.train = 6, .val = 0, .test = 0});
    replace_in(folder.path() / "transforms_train.json", "\"time\"", "\"timestep\"");
    CHECK(notes_with(load_dataset(folder.str()), "'timestep' is not read: call it 'time'").size() == 1);
  }

  TEST_CASE("times.txt: a byte order mark before it, remarks, and # in a picture's name") {
    const TempFolder folder;
    write_moving_ball(folder.path(), {.train = 3, .val = 0, .test = 0});
    replace_in(folder.path() / "transforms_train.json", "\"time\"", "\"timestamp\"");
    replace_in(folder.path() / "transforms_train.json", "train/r_1", "train/r#1");
    fs::rename(folder.path() / "train/r_1.png", folder.path() / "train/r#1.png");
    write_text(folder.path() / "times.txt",
               "\xEF\xBB\xBFtrain/r_0.png 0\n# between\ntrain/r#1.png 3 # the middle\ntrain/r_2.png 4\n");
    const Dataset data = load_dataset(folder.str());
    CHECK(data.splits[0].frames[1].time == doctest::Approx(0.75));
  }

  TEST_CASE("pictures that two splits list are one picture in the order of names") {
    const TempFolder folder;
    write_moving_ball(folder.path());
    fs::copy_file(folder.path() / "transforms_val.json", folder.path() / "transforms_test.json",
                  fs::copy_options::overwrite_existing);
    const Dataset data = load_dataset(folder.str(), {.rules = {.times = "order"}});
    const std::vector<Frame>&val = data.find("val")->frames, &test = data.find("test")->frames;
    REQUIRE(val.size() == test.size());
    for (std::size_t i = 0; i < val.size(); ++i) CHECK(val[i].time == test[i].time);
    CHECK(val.front().time != val.back().time);
  }

  TEST_CASE("absolute paths into the data set are paths within it: masks beside the pictures are found") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 3));
    for (int i = 0; i < 3; ++i) write_png(folder.path() / "masks" / ("frame_" + padded(i) + ".png"), white);
    replace_in(folder.path() / "transforms.json", "images/", folder.str() + "/images/");
    const Dataset data = load_dataset(folder.str(), {.rules = {.masks = "subject"}});
    CHECK(frames_of(data) == 3);
    CHECK(notes_with(data, "another machine").empty());
  }

  TEST_CASE("a picture in a folder with mask in its name is not its own mask") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 3));
    replace_in(folder.path() / "transforms.json", "images/frame_", "images_masked/frame_");
    fs::rename(folder.path() / "images", folder.path() / "images_masked");
    CHECK_FALSE(load_dataset(folder.str()).masks);
  }

  TEST_CASE("a picture under two spellings is one") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 16));
    const Dataset once = load_dataset(folder.str());
    std::ifstream in(folder.path() / "transforms.json");
    nlohmann::json file = nlohmann::json::parse(in);
    nlohmann::json more = file["frames"];
    for (auto& frame : more) {
      frame["file_path"] = "./" + frame["file_path"].get<std::string>();
      file["frames"].push_back(frame);
    }
    write_text(folder.path() / "transforms.json", file.dump());
    const Dataset twice = load_dataset(folder.str());
    CHECK(frames_of(twice) == frames_of(once));
    CHECK(twice.find("test")->frames.size() == once.find("test")->frames.size());
  }

  TEST_CASE("the word mask may be part of pictures' own names") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 3));
    replace_in(folder.path() / "transforms.json", "images/frame_", "images/maskdance_");
    for (int i = 0; i < 3; ++i) {
      const std::string name = "maskdance_" + padded(i) + ".png";
      fs::rename(folder.path() / "images" / ("frame_" + padded(i) + ".png"), folder.path() / "images" / name);
      write_png(folder.path() / "masks" / name, white);
    }
    CHECK(frames_of(load_dataset(folder.str(), {.rules = {.masks = "subject"}})) == 3);
  }
}

}  // namespace
