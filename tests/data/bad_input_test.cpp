// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <random>

#include "data/expect_error.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

/// What load_dataset says about each kind of bad input.
namespace {

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;

const std::string kMatrix = matrix_text(orbit_matrix(0.3));

/// A good data set of four 4 x 4 training pictures, for tests to spoil.
struct Spoiled {
  Spoiled() {
    for (int i = 0; i < 4; ++i) write_png(picture(i), flat_png(4, 4));
    write(frames());
  }
  fs::path picture(int i) const { return folder.path() / "train" / ("r_" + std::to_string(i) + ".png"); }
  static std::vector<std::string> frames() {
    std::vector<std::string> list;
    for (int i = 0; i < 4; ++i)
      list.push_back(frame_text("./train/r_" + std::to_string(i), "0." + std::to_string(i), kMatrix));
    return list;
  }
  void write_raw(const std::string& text) const { write_text(folder.path() / "transforms_train.json", text); }
  void write(const std::vector<std::string>& list) const { write_raw(transforms_text(list)); }
  /// Replaces frame 2.
  void write_third(const std::string& frame) const {
    std::vector<std::string> list = frames();
    list[2] = frame;
    write(list);
  }
  void expect(const std::vector<std::string>& parts, const LoadOptions& options = {}) const {
    expect_error([&] { load_dataset(folder.str(), options); }, parts);
  }
  TempFolder folder;
};

const std::string kThird = "transforms_train.json, frame 2: ";

TEST_SUITE("data/bad_input") {
  TEST_CASE("the set that is spoiled below is good") {
    CHECK(load_dataset(Spoiled().folder.str()).splits.size() == 1);
  }

  TEST_CASE("the whole text of one message") {
    const Spoiled set;
    set.write_third(frame_text("train/r_2", "\"soon\"", kMatrix));
    CHECK(error_of([&] { load_dataset(set.folder.str()); }) ==
          set.folder.str() +
              "/transforms_train.json, frame 2: 'time' is not a number\n"
              "  expected: a finite number\n"
              "  got:      the text 'soon'");
  }

  TEST_CASE("no such folder, a file instead, a folder of another kind") {
    const TempFolder folder;
    expect_error([&] { load_dataset(folder.str() + "/none"); }, {"/none: the data set does not exist"});
    expect_error([] { load_dataset(""); }, {"the data set does not exist"});
    write_text(folder.path() / "file.json", "{}");
    expect_error([&] { load_dataset(folder.str() + "/file.json"); },
                 {"file.json: the data set is not a folder", "give the folder that holds it"});
    expect_error([&] { load_dataset(folder.str()); },
                 {"no known kind of data set",
                  "transforms_train.json, transforms_val.json or transforms_test.json", "none of them"});
    write_text(folder.path() / "transforms.json", "{}");
    expect_error([&] { load_dataset(folder.str()); }, {"transforms.json: 'frames' is missing"});
  }

  TEST_CASE("splits asked for that are not there") {
    const Spoiled set;
    set.expect({"transforms_test.json: the test split was asked for and is not there"},
               {.splits = {"train", "test"}});
    set.expect({"there is no such split", "train, val or test", "'trian'"}, {.splits = {"trian"}});
  }

  TEST_CASE("an image that is missing") {
    const Spoiled set;
    fs::remove(set.picture(2));
    set.expect({kThird + "the image is missing", "'./train/r_2', also with .png, .jpg or .jpeg added",
                "no such file"});
  }

  TEST_CASE("an image that is cut short") {
    const Spoiled set;
    const Bytes whole = png_bytes(flat_png(4, 4));
    write_bytes(set.picture(2), Bytes(whole.begin(), whole.end() - 20));
    set.expect(
        {"train/r_2.png (train, frame 2): the image is truncated or damaged", "the file ends too early"});
    write_bytes(set.picture(2), Bytes(whole.begin(), whole.begin() + 12));
    set.expect({"train/r_2.png (train, frame 2): the image is truncated"});
    write_bytes(set.picture(2), {});
    set.expect({"train/r_2.png (train, frame 2): the image is not a PNG", "an empty file"});
  }

  TEST_CASE("of several bad images the first is named, on any number of threads") {
    const Spoiled set;
    const Bytes whole = png_bytes(flat_png(4, 4));
    for (int i = 1; i < 4; ++i) write_bytes(set.picture(i), Bytes(whole.begin(), whole.end() - 14 - i));
    for (const std::size_t threads : {1, 2, 4}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      for (int again = 0; again < 20; ++again) set.expect({"train/r_1.png (train, frame 1)"});
    }
  }

  TEST_CASE("images of different sizes: both are named") {
    const Spoiled set;
    write_png(set.picture(2), flat_png(4, 3));
    set.expect({"frame 2): the images of a split differ in size", "4 x 4 as in r_0.png", "4 x 3 in r_2.png"});
  }

  TEST_CASE("a downscale that leaves nothing") {
    const Spoiled set;
    set.expect({"--downscale 5 leaves nothing of the image", "shorter side, 4", "4 x 4"}, {.downscale = 5});
    set.expect({"--downscale: out of range", "at least 1", "got:      0"}, {.downscale = 0});
    set.expect({"--downscale: out of range"}, {.downscale = -2});
  }

  TEST_CASE("a picture too large for any memory, many times over") {
    const Spoiled set;
    Bytes bomb = png_header(16384, 16384, 1, PngKind::grey);
    bomb.resize(bomb.size() + 40000);
    write_bytes(set.picture(0), bomb);
    set.write(std::vector<std::string>(3000, frame_text("train/r_0", "0.5", kMatrix)));
    const std::string cache = set.folder.str() + "/cache";
    try {
      load_dataset(set.folder.str(), {.cache = cache});
      FAIL_CHECK("no error was thrown");
    } catch (const Error& error) {
      const std::string message = error.what();
      CAPTURE(message);
      for (const char* part : {"do not fit into memory", "GB", "--downscale 2"})  // nor onto the disk
        CHECK(message.find(part) != std::string::npos);
    }
  }

  TEST_CASE("malformed JSON: line, column and field") {
    const Spoiled set;
    set.write_raw("{\"camera_angle_x\": 0.8,\n \"frames\": [,]}");
    set.expect({"transforms_train.json: malformed JSON at line 2, column 13, in frames[0]",
                "got:      syntax error"});
    set.write_raw("");
    set.expect({"malformed JSON at line 1, column 1"});
    set.write_raw("{} {}");
    set.expect({"malformed JSON at line 1, column 4"});
    const std::string whole = transforms_text(Spoiled::frames());
    set.write_raw(whole.substr(0, whole.size() / 2));
    set.expect({"malformed JSON at line", "in frames["});
  }

  TEST_CASE("every truncation of the JSON is an error") {
    const Spoiled set;
    const std::string whole = transforms_text(Spoiled::frames());
    for (std::size_t n = 0; n + 2 < whole.size(); n += 7) {
      CAPTURE(n);
      set.write_raw(whole.substr(0, n));
      set.expect({"transforms_train.json: malformed JSON"});
    }
  }

  TEST_CASE("damaged JSON gives an error or a data set, never a crash") {
    const Spoiled set;
    const std::string whole = transforms_text(Spoiled::frames());
    std::mt19937 random(11);
    int refused = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      std::string text = whole;
      for (unsigned k = 0; k < 1 + trial % 3u; ++k) text[random() % text.size()] = char(random());
      set.write_raw(text);
      try {
        const Dataset dataset = load_dataset(set.folder.str());
        CHECK(dataset.splits[0].frames.size() == 4);
      } catch (const Error& error) {
        ++refused;
        CHECK(error.fault == Fault::input);
      }
    }
    CHECK(refused > 500);
  }

  TEST_CASE("NaN and numbers beyond double, in the field where they stand") {
    const Spoiled set;
    for (const std::string bad : {"NaN", "Infinity", "-Infinity", "1e999", "-1e999"}) {
      CAPTURE(bad);
      set.write_third(frame_text("train/r_2", bad, kMatrix));
      set.expect({"transforms_train.json: malformed JSON", "in frames[2].time", "no NaN or Infinity"});
      set.write_third(frame_text("train/r_2", "0.5", "[[1,0,0,0],[0," + bad + ",0,0],[0,0,1,0],[0,0,0,1]]"));
      set.expect({"transforms_train.json: malformed JSON", "in frames[2].transform_matrix[1][1]"});
    }
  }

  TEST_CASE("JSON nested too deeply, keys given twice, other tops") {
    const Spoiled set;
    set.write_raw("{\"frames\": " + std::string(100000, '[') + "}");
    set.expect({"the JSON is nested too deeply", "at most 64 levels"});
    set.write_raw("{\"frames\": " + std::string(60, '[') + std::string(60, ']') + "}");
    set.expect({kThird.substr(0, 21) + ", frame 0: this is not a frame", "an array of 1"});
    set.write_third("{\"time\": 0.5, \"file_path\": \"train/r_2\", \"time\": 0.6, \"transform_matrix\": " +
                    kMatrix + "}");
    set.expect({"the field frames[2].time is there twice"});
    set.write_raw("[1, 2]");
    set.expect({"this is not a transforms file", "an array of 2"});
    set.write_raw("{\"camera_angle_x\": 0.8}");
    set.expect({"'frames' is missing"});
    set.write_raw("{\"frames\": 7}");
    set.expect({"'frames' is not an array", "got:      7"});
  }

  TEST_CASE("an empty split") {
    const Spoiled set;
    set.write({});
    set.expect({"transforms_train.json: the split is empty", "at least one frame"});
  }

  TEST_CASE("a time that some frames lack, or that is no number") {
    const Spoiled set;
    set.write_third(frame_text("train/r_2", "", kMatrix));
    set.expect(
        {kThird + "'time' is missing", "3 of 4 frames with 'time'", "give every frame a time, or none"});
    set.write_third(frame_text("train/r_2", "null", kMatrix));
    set.expect({kThird + "'time' is not a number", "got:      null"});
    set.write_third(frame_text("train/r_2", "1e300", kMatrix));
    set.expect({kThird + "'time' is not finite or too large", "1e+300"});
  }

  TEST_CASE("a transform_matrix of the wrong shape or kind") {
    const Spoiled set;
    const auto refuse = [&](const std::string& matrix, const std::vector<std::string>& parts) {
      CAPTURE(matrix);
      set.write_third(frame_text("train/r_2", "0.5", matrix));
      set.expect(parts);
    };
    refuse("[[1,0,0,0],[0,1,0,0]]", {kThird + "'transform_matrix' has the wrong shape", "an array of 2"});
    refuse("[[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]",
           {kThird + "'transform_matrix' row 1 has the wrong shape"});
    refuse("[[1,0,0,0],[0,1,\"x\",0],[0,0,1,0],[0,0,0,1]]",
           {kThird + "'transform_matrix' row 1, column 2 is not a number"});
    refuse("[[1,0,0,0],[0,1,null,0],[0,0,1,0],[0,0,0,1]]",
           {kThird + "'transform_matrix' row 1, column 2", "got:      null"});
    refuse("\"identity\"", {kThird + "'transform_matrix' has the wrong shape", "the text 'identity'"});
    refuse("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]",
           {kThird + "'transform_matrix' has a wrong last row", "0 0 1 1"});
    refuse("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]", {kThird + "'transform_matrix' mirrors the camera"});
    refuse("[[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]", {kThird + "'transform_matrix' is singular"});
    refuse("[[1,0,0,0],[0,1,0,0],[0,0,1,1e20],[0,0,0,1]]",
           {kThird + "'transform_matrix' has a number that is not finite"});
    refuse("[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]",
           {kThird + "'transform_matrix' has a scale", "scale 2"});
    set.write_third("{\"file_path\": \"train/r_2\", \"time\": 0.5}");
    set.expect({kThird + "'transform_matrix' is missing"});
  }

  TEST_CASE("a lens that is missing, impossible or distorted") {
    const Spoiled set;
    const auto refuse = [&](const std::string& head, const std::vector<std::string>& parts) {
      CAPTURE(head);
      set.write_raw(transforms_text(Spoiled::frames(), head));
      set.expect(parts);
    };
    refuse("", {"frame 0: there is no focal length"});
    refuse("\"camera_angle_x\": 0,", {"'camera_angle_x' is no field of view", "got:      0"});
    refuse("\"camera_angle_x\": 3.2,", {"'camera_angle_x' is no field of view"});
    refuse("\"camera_angle_x\": 39.6,", {"it looks like degrees"});
    refuse("\"camera_angle_x\": \"0.8\",", {"transforms_train.json: 'camera_angle_x' is not a number"});
    refuse("\"fl_x\": 4, \"w\": 800,", {"'w' is not the picture's size", "expected: 4"});
    refuse("\"fl_x\": 4, \"k1\": -9,", {"frame 0: the lens distortion cannot be undone", "undistort"});
    refuse("\"fl_x\": 4, \"camera_model\": \"FULL_OPENCV\",",
           {"'camera_model' is not supported", "'FULL_OPENCV'"});
    refuse("\"fl_x\": 4, \"p1\": 0.1, \"camera_model\": \"OPENCV_FISHEYE\",",
           {"a fisheye lens has no tangential distortion"});
  }

  TEST_CASE("a file_path that is missing or no path") {
    const Spoiled set;
    const std::string rest = "\"time\": 0.5, \"transform_matrix\": " + kMatrix + "}";
    set.write_third("{" + rest);
    set.expect({kThird + "'file_path' is missing"});
    set.write_third("{\"file_path\": 3, " + rest);
    set.expect({kThird + "'file_path' is not a path", "got:      3"});
    set.write_third("{\"file_path\": \"\", " + rest);
    set.expect({kThird + "'file_path' is not a path"});
    set.write_third("{\"file_path\": \"train/r_2\\u0000.png\", " + rest);
    set.expect({kThird + "'file_path' holds a zero byte", "r_2\\x00.png"});
    set.write_third("{\"file_path\": \"train/a\\nb\", " + rest);
    set.expect({kThird + "the image is missing", "'train/a\\x0ab'"});
    set.write_third("{\"file_path\": \"" + std::string(300, 'n') + "\", " + rest);
    set.expect({kThird + "'file_path' cannot be looked up", "nnn..."});
    set.write_third("{\"file_path\": \"train\", " + rest);
    set.expect({kThird + "the image is missing"});
  }

  TEST_CASE("a file_path that leads out of the folder") {
    const Spoiled set;
    const TempFolder outside;
    write_png(outside.path() / "secret.png", flat_png(4, 4));
    fs::create_symlink(outside.path() / "secret.png", set.folder.path() / "link.png");
    fs::create_directory_symlink(outside.path(), set.folder.path() / "door");
    const std::string up = "../" + outside.path().filename().string() + "/secret";
    const std::string sibling = "../" + set.folder.path().filename().string() + "_2/a.png";
    for (const std::string& path :
         {up, up + ".png", "train/../../" + outside.path().filename().string() + "/secret",
          outside.str() + "/secret.png", std::string("link"), std::string("link.png"),
          std::string("door/secret"), std::string("door/secret.png"), sibling, std::string("/etc/passwd"),
          std::string(".."), std::string("../..")}) {
      CAPTURE(path);
      set.write_third(frame_text(path, "0.5", kMatrix));
      set.expect({kThird + "'file_path' leads out of the data set's folder"});
    }
    set.write_third(frame_text("train/../train/r_2", "0.5", kMatrix));
    CHECK(load_dataset(set.folder.str()).splits[0].frames[2].name == "r_2");
    set.write_third(frame_text(set.picture(2).string(), "0.5", kMatrix));
    CHECK(load_dataset(set.folder.str()).splits[0].frames[2].name == "r_2");
  }

  TEST_CASE("a fault in the train split is found even when only its times are wanted") {
    const Spoiled set;
    write_png(set.folder.path() / "t.png", flat_png(4, 4));
    write_text(set.folder.path() / "transforms_test.json",
               transforms_text({frame_text("t", "0.5", kMatrix)}));
    set.write_raw("{");
    set.expect({"transforms_train.json: malformed JSON"}, {.splits = {"test"}});
    CHECK(load_dataset(set.folder.str(), {.splits = {"test"}, .time_map = TimeMap{}}).splits.size() == 1);
  }
}

}  // namespace
