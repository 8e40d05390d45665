// SPDX-License-Identifier: Apache-2.0
#include "data/rig_layouts.hpp"

#include <random>
#include <set>

#include "data/expect_error.hpp"
#include "data/layouts/read_scene.hpp"
#include "data/wild.hpp"
#include "math/camera.hpp"

/// Every layout of rigs: what is read, and the same after `convert`.
namespace {

using namespace splinevox;
using namespace splinevox::test;

/// The largest distance, in pixels, of where random points appear from where the camera must show them.
double worst_of(const Frame& frame, const TrueCamera& camera) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-0.7, 0.7);
  double worst = 0;
  for (int i = 0; i < 20; ++i) {
    const std::array<double, 3> p{coordinate(random), coordinate(random), coordinate(random)};
    const Projection seen = project(frame.camera, {p[0], p[1], p[2]});
    const auto [u, v] = camera.see(p);
    worst = std::max({worst, std::abs(seen.u - u), std::abs(seen.v - v)});
  }
  return worst;
}

/// The number at the end of a camera's name.
std::size_t number_of(const std::string& name) {
  return std::stoul(name.substr(name.find_first_of("0123456789")));
}

/// Every camera is known, stands still and sees every moment; frames are those of the true cameras.
void check_rig(const Dataset& data, const Cameras& cameras, std::size_t moments) {
  REQUIRE(data.cameras.size() == cameras.size());
  for (const RigCamera& camera : data.cameras) CHECK(camera.still);
  std::set<std::pair<int, double>> seen;
  std::set<double> times;
  for (const Split& split : data.splits)
    for (const Frame& frame : split.frames) {
      REQUIRE(frame.camera_id >= 0);
      const std::size_t c = number_of(data.cameras[std::size_t(frame.camera_id)].name);
      CHECK(worst_of(frame, cameras.at(c)) < kPixel);
      if (frame.image.has_values() && !data.has_alpha && frame.image.pixel(3, 3)[2] == 257 * 90) {
        CHECK(frame.image.pixel(3, 3)[0] == 257 * 10 * c);
        CHECK(frame.image.pixel(3, 3)[1] == 257 * 20 * std::lround(frame.time * double(moments - 1)));
      }
      seen.emplace(frame.camera_id, frame.time);
      times.insert(frame.time);
    }
  CHECK(times.size() == moments);
  CHECK(seen.size() == moments * cameras.size());
}

/// Reads the folder and what `convert` makes of it.
Dataset check_both(const TempFolder& folder, const Cameras& cameras, std::size_t moments,
                   const std::string& format) {
  Dataset data = load_dataset(folder.str());
  CHECK(data.format == format);
  check_rig(data, cameras, moments);
  const TempFolder out;
  convert_dataset(folder.str(), out.str() + "/converted");
  const Dataset again = load_dataset(out.str() + "/converted");
  REQUIRE(again.splits.size() == data.splits.size());
  for (std::size_t s = 0; s < data.splits.size(); ++s) {
    REQUIRE(again.splits[s].frames.size() == data.splits[s].frames.size());
    for (std::size_t i = 0; i < data.splits[s].frames.size(); ++i) {
      CHECK(again.splits[s].frames[i].image == data.splits[s].frames[i].image);
      CHECK(again.splits[s].frames[i].time == data.splits[s].frames[i].time);
      const int camera = data.splits[s].frames[i].camera_id;
      REQUIRE((camera >= 0) == (again.splits[s].frames[i].camera_id >= 0));
      if (camera >= 0)
        CHECK(again.cameras.at(std::size_t(again.splits[s].frames[i].camera_id)).name ==
              data.cameras.at(std::size_t(camera)).name);
      CHECK(again.splits[s].frames[i].camera.position == data.splits[s].frames[i].camera.position);
    }
  }
  CHECK(again.box == data.box);
  return data;
}

/// Which camera each frame of a split is of.
std::set<std::string> names_in(const Dataset& data, const char* split) {
  std::set<std::string> names;
  if (const Split* found = data.find(split))
    for (const Frame& frame : found->frames) names.insert(data.cameras.at(std::size_t(frame.camera_id)).name);
  return names;
}

/// The masks that a reader names.
std::set<std::string> masks_in(const TempFolder& folder) {
  std::set<std::string> masks;
  for (const data::RawSplit& split : data::open_scene(folder.path(), {}).scene.splits)
    for (const data::RawFrame& frame : split.frames)
      if (!frame.mask.empty()) masks.insert(frame.mask);
  return masks;
}

TEST_SUITE("data/rig layouts") {
  TEST_CASE("Dynamic 3D Gaussians: the files are the splits, a moment's number is its time") {
    const TempFolder folder;
    const Cameras cameras = rig_cameras(6, {11, 12, 5.5, 4.25});
    write_gaussians(folder.path(), cameras);
    const Dataset data = check_both(folder, cameras, 4, "Dynamic 3D Gaussians");
    CHECK(names_in(data, "train") == std::set<std::string>{"0", "1", "2", "3"});
    CHECK(names_in(data, "test") == std::set<std::string>{"4", "5"});
    CHECK(data.find("test")->frames[1].name == "5_0000");
    CHECK(masks_in(folder).size() == 24);
    CHECK(masks_in(folder).contains("seg/3/0002.png"));
    fs::remove(folder.path() / "seg/3/0002.png");
    CHECK(masks_in(folder).size() == 23);
    fs::remove(folder.path() / "test_meta.json");
    CHECK(frames_of(load_dataset(folder.str())) == 16);
    write_gaussians_file(folder.path(), "test", cameras, 4, 6, 3);
    CHECK(notes_with(load_dataset(folder.str()), "has 4 moments and the test split 3").size() == 1);
  }

  TEST_CASE("PINF: films by index, a film that moves, the volume of the smoke") {
    if (!has_ffmpeg()) return;
    const TempFolder folder;
    Cameras cameras = true_cameras({}, 4);
    write_pinf(folder.path(), cameras);
    const Dataset data = load_dataset(folder.str());
    CHECK(data.format == "PINF");
    REQUIRE(data.find("train")->frames.size() == 12);
    REQUIRE(data.find("test")->frames.size() == 4);
    for (const Frame& frame : data.find("train")->frames)
      CHECK(worst_of(frame, cameras[number_of(frame.name.substr(0, 7))]) < kPixel);
    for (int k = 0; k < 4; ++k)
      CHECK(worst_of(data.find("test")->frames[std::size_t(k)], {orbit_matrix(2 + 0.1 * k), {}, 0}) < kPixel);
    CHECK(data.find("test")->frames[3].name == "test00_0003");
    CHECK(data.find("test")->frames[3].time == 1);
    CHECK(data.find("test")->frames[3].image.pixel(3, 3)[0] > 60000);
    CHECK_FALSE(data.cameras.back().still);
    CHECK(data.cameras.front().still);
    REQUIRE(data.box);  // columns of the matrix belong to z, y, x
    CHECK(data.box->lo.x == 0.5f);
    CHECK(data.box->hi.x == 1.5f);
    CHECK(data.box->lo.y == -0.5f);
    CHECK(data.box->hi.y == 1.5f);
    CHECK(data.box->lo.z == -3.75f);
    CHECK(data.box->hi.z == 0.25f);
  }

  TEST_CASE("EasyMocap: axes or matrices, both names of the distortion, pictures or films") {
    const TempFolder folder;
    const Cameras cameras = rig_cameras(5, kBent);
    write_easymocap(folder.path(), cameras);
    const Dataset data = check_both(folder, cameras, 4, "EasyMocap");
    CHECK(text_in(folder.path() / "intri.yml").find("[ 11, 0, 5,\n       0, 12, 3.75,") != std::string::npos);
    CHECK(first_frame(data).camera.cx == 5.5);  // OpenCV counts from the centre of the first pixel
    CHECK(first_frame(data).camera.cy == 4.25);
    CHECK(masks_in(folder).size() == 20);
    CHECK(masks_in(folder).contains("mask/02/000003.png"));
    replace_in(folder.path() / "intri.yml", "names:\n  - \"00\"\n  - \"01\"\n",
               "# by hand\nH_00: 16\nW_00: 24.\nnames: [ \"00\", '01',\n    ");
    replace_in(folder.path() / "intri.yml", "  - \"02\"\n  - \"03\"\n  - \"04\"\n",
               "\"02\", \"03\",\"04\" ]\n\n");
    replace_in(folder.path() / "intri.yml", "data: [ ", "data: [");
    replace_in(folder.path() / "intri.yml", "[11,", "[22,");  // of the first camera alone
    const Dataset again = load_dataset(folder.str());
    for (int c = 0; c < 2; ++c)
      CHECK(again.find("train")->frames[std::size_t(c)].camera.fx ==
            data.find("train")->frames[std::size_t(c)].camera.fx);
    CHECK(again.find("train")->frames[0].camera.cx ==
          cameras[0].lens.cx / 2);  // for a picture twice as large
    if (!has_ffmpeg()) return;
    fs::remove_all(folder.path() / "images");
    write_easymocap(folder.path(), cameras, 0);
    for (int c = 0; c < 5; ++c) CHECK(write_film(folder.path() / "videos" / (numbered("", c) + ".mp4"), 6));
    check_rig(load_dataset(folder.str()), cameras, 6);
  }

  TEST_CASE("a transforms.json of one moment: poses by the names of folders, wherever these lie") {
    for (const char* place : {"", "images", "frames"}) {
      CAPTURE(place);
      const TempFolder folder;
      const Cameras cameras = rig_cameras(4, kBent);
      write_still_model(folder.path(), cameras);
      CHECK(load_dataset(folder.str()).cameras.empty());
      write_camera_folders(folder.path() / place, 4, 5);
      write_png(folder.path() / "masks/cam02/0003.png", flat_png(kWide, kHigh));
      write_png(folder.path() / place / "backdrop/0000.png", flat_png(kWide, kHigh));
      write_png(folder.path() / place / "backdrop/0001.png", flat_png(kWide, kHigh));
      const Dataset data = check_both(folder, cameras, 5, "nerfstudio / instant-ngp");
      CHECK(notes_with(data, "one pose for every camera").size() == 1);
      CHECK(notes_with(data, "not read, for no camera has its name: 'backdrop'").size() == 1);
      CHECK(masks_in(folder) == std::set<std::string>{"masks/cam02/0003.png"});
      CHECK(notes_with(data, "every eighth picture").size() == 1);  // four cameras are too few to lose one
    }
  }

  TEST_CASE("poses whose own pictures lie in a folder per camera do not hide what the cameras took") {
    const TempFolder folder;
    const Cameras cameras = rig_cameras(4, kBent);
    write_still_model(folder.path(), cameras);
    for (int c = 0; c < 4; ++c) {
      const std::string name = numbered("cam", c);
      replace_in(folder.path() / "transforms.json", "images/" + name + ".png",
                 "images/" + name + "/0000.png");
      fs::create_directories(folder.path() / "images" / name);
      fs::rename(folder.path() / "images" / (name + ".png"), folder.path() / "images" / name / "0000.png");
    }
    write_camera_folders(folder.path() / "frames", 4, 5);
    check_both(folder, cameras, 5, "nerfstudio / instant-ngp");
  }

  TEST_CASE("a transforms.json of one moment: films; lists of file names divide the cameras") {
    if (!has_ffmpeg()) return;
    const TempFolder folder;
    const Cameras cameras = rig_cameras(3);
    write_still_model(
        folder.path(), cameras,
        "\"train_filenames\": [\"images/cam00.png\", \"images/cam02.png\"], \"test_filenames\": "
        "[\"images/cam01.png\"],");
    for (int c = 0; c < 3; ++c)
      CHECK(write_film(folder.path() / (numbered("cam", c) + ".mp4"), c == 2 ? 20 : 19, "blue",
                       "-color_trc arib-std-b67"));
    const Dataset data = load_dataset(folder.str());
    CHECK(notes_with(data, "an HDR film (HLG)").size() == 1);
    CHECK(names_in(data, "test") == std::set<std::string>{"cam01"});
    CHECK(data.find("train")->frames.size() == 39);
    CHECK(notes_with(data, "films have from 19 to 20 frames").size() == 1);
    CHECK(write_film(folder.path() / "cam01.mp4", 9));
    expect_error([&] { load_dataset(folder.str()); }, {"films differ in length by more than a tenth",
                                                       "20 frames, as in 'cam02.mp4'", "9 in 'cam01.mp4'"});
  }

  TEST_CASE("photographs with a film of the same name beside them stay photographs") {
    if (!has_ffmpeg()) return;
    const TempFolder folder;
    const Cameras cameras = rig_cameras(3);
    write_still_model(folder.path(), cameras);
    std::vector<std::string> frames;
    for (int c = 0; c < 3; ++c) {
      const std::string stem = "images/IMG_010" + std::to_string(c);
      write_png(folder.path() / (stem + ".png"), rig_picture(c, 0));
      CHECK(write_film(folder.path() / (stem + ".mov"), 6));
      frames.push_back(frame_text(stem + ".png", "", matrix_text(cameras[std::size_t(c)].to_world))
                           .insert(1, lens_fields(cameras[std::size_t(c)].lens)));
    }
    write_text(folder.path() / "transforms.json", transforms_text(frames, ""));
    LoadOptions options;
    options.rules.times = "none";
    std::size_t all = 0;
    for (const Split& split : load_dataset(folder.str(), options).splits) all += split.frames.size();
    CHECK(all == 3);
  }

  TEST_CASE("a COLMAP model of one moment: poses by folder; one of all pictures is read as it is") {
    for (const bool own_folders : {false, true}) {
      CAPTURE(own_folders);
      const TempFolder folder;
      Cameras cameras = true_cameras({}, 6);
      write_colmap_text(folder.path(), cameras, ColmapLens{"PINHOLE", 1, {11, 11, 6, 4}});
      fs::remove_all(folder.path() / "images");
      for (int c = 0; c < 6; ++c)
        replace_in(folder.path() / "sparse/0/images.txt", "frame_" + padded(c) + ".png",
                   numbered("cam", c) + (own_folders ? "/0002.png" : ".png"));
      write_camera_folders(folder.path() / (own_folders ? "images" : ""), 6, 5);
      const Dataset data = check_both(folder, cameras, 5, "COLMAP");
      CHECK(data.box);
      CHECK(names_in(data, "test").size() == 1);
    }
  }

  TEST_CASE("of a rig of five cameras or more, whole cameras are held out, none of them at an end") {
    for (const int count : {5, 8, 15, 16, 25}) {
      CAPTURE(count);
      const TempFolder folder;
      Cameras cameras;
      for (int c = 0; c < count; ++c) cameras.push_back({orbit_matrix(0.06 * c), {}, 0});
      write_still_model(folder.path(), cameras);
      write_camera_folders(folder.path(), count, 3);
      const Dataset data = load_dataset(folder.str());
      const std::set<std::string> test = names_in(data, "test"), train = names_in(data, "train");
      CHECK(test.size() == std::size_t(std::max(1, count / 8)));
      CHECK(test.size() + train.size() == std::size_t(count));
      CHECK(train.contains("cam00"));
      CHECK(train.contains(numbered("cam", count - 1)));
      CHECK(data.find("test")->frames.size() == 3 * test.size());
      CHECK(notes_with(data, " cameras, which stand still, are held out: 'cam").size() == 1);
    }
    const TempFolder ring;
    Cameras cameras;
    for (int c = 0; c < 8; ++c) cameras.push_back({orbit_matrix(0.25 * 3.14159265358979 * c), {}, 0});
    write_still_model(ring.path(), cameras);
    write_camera_folders(ring.path(), 8, 3);
    const std::set<std::string> test = names_in(load_dataset(ring.str()), "test");
    CHECK((test == std::set<std::string>{"cam03"} || test == std::set<std::string>{"cam04"}));
  }

  TEST_CASE("cameras that take turns are no rig of which one can be spared") {
    const TempFolder folder;
    std::vector<std::string> frames;
    for (int i = 0; i < 24; ++i) {
      const std::string path = numbered("cam", i % 6) + "/" + padded(i) + ".png";
      write_png(folder.path() / path, rig_picture(i % 6, 0));
      frames.push_back(frame_text(path, std::to_string(i), matrix_text(orbit_matrix(i % 6))));
    }
    write_text(folder.path() / "transforms.json", transforms_text(frames));
    const Dataset data = load_dataset(folder.str());
    CHECK(data.cameras.size() == 6);
    CHECK(notes_with(data, "every eighth picture").size() == 1);
  }
}

}  // namespace
