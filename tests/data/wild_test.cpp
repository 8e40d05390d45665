// SPDX-License-Identifier: Apache-2.0
#include "data/wild.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

#include "data/expect_error.hpp"
#include "splinevox/data/scene.hpp"

/// Folders as people have them: near misses of the layouts that are known, and what lies beside the pictures.
namespace {

using namespace splinevox;
using namespace splinevox::test;

const ColmapLens kPinholeLens{"PINHOLE", 1, {11, 11, 6, 4}};

/// The line of an image in images.txt, without its points.
std::string image_line(int i, const TrueCamera& camera, const std::string& name) {
  std::string line = std::to_string(i + 1);
  for (const double v : quaternion_of(camera)) line.append(" ").append(exactly(v));
  for (const double v : translation_of(camera)) line.append(" ").append(exactly(v));
  return line + " 1 " + name;
}

TEST_SUITE("data/wild") {
  TEST_CASE("COLMAP by hand: an image's second line is known by what is in it") {
    const Cameras cameras = true_cameras({}, 10);
    for (const std::string between : {"\n", "\n\n", "\n\n\n", "\n1.5 2.5 -1 3 4 7\n", "\n1 2 3\n\n"})
      for (const std::string stem : {"frame_", "frame of mine "}) {
        CAPTURE(between);
        CAPTURE(stem);
        const TempFolder folder;
        write_colmap_text(folder.path(), cameras, kPinholeLens);
        fs::remove_all(folder.path() / "images");
        write_pictures(folder.path() / "images", 10, stem);
        std::string images = "# Image list\n";
        for (int i = 0; i < 10; ++i)
          images += image_line(i, cameras[std::size_t(i)], stem + padded(i) + ".png") + between;
        write_text(folder.path() / "sparse/0/images.txt", images);
        write_text(folder.path() / "sparse/0/rigs.txt", "# Rig calib list\n1 1 CAMERA 1\n");
        write_text(folder.path() / "sparse/0/frames.txt", "# Frame list\n1 1 1 0 0 0 0 0 0 1 CAMERA 1 1\n");
        CHECK(frames_of(load_dataset(folder.str())) == 10);
      }
  }

  TEST_CASE("COLMAP from Windows: paths with \\, and a byte order mark") {
    const Cameras cameras = true_cameras({}, 10);
    const TempFolder folder;
    write_colmap_text(folder.path(), cameras, kPinholeLens);
    fs::create_directories(folder.path() / "images/cam0");
    write_pictures(folder.path() / "images/cam0", 10);
    for (int i = 0; i < 10; ++i) fs::remove(folder.path() / "images" / ("frame_" + padded(i) + ".png"));
    std::string images = "\xEF\xBB\xBF# Image list\n";
    for (int i = 0; i < 10; ++i)
      images += image_line(i, cameras[std::size_t(i)], "cam0\\frame_" + padded(i) + ".png") + "\n\n";
    write_text(folder.path() / "sparse/0/images.txt", images);
    const Dataset data = load_dataset(folder.str());
    CHECK(frames_of(data) == 10);
    CHECK(notes_with(data, "10 pictures have paths of Windows").size() == 1);
  }

  TEST_CASE("COLMAP: models where other programs put them, with their own pictures") {
    for (const std::string place :
         {"colmap_sparse/0", "distorted/sparse/0", "dense/0/sparse", "colmap_text"}) {
      CAPTURE(place);
      const TempFolder folder;
      write_colmap_text(folder.path(), true_cameras({}, 5), kPinholeLens);
      fs::create_directories((folder.path() / place).parent_path());
      fs::rename(folder.path() / "sparse/0", folder.path() / place);
      fs::remove(folder.path() / "sparse");
      if (place.starts_with("di")) write_pictures(folder.path() / "input", 5);
      if (place.starts_with("de")) write_pictures(folder.path() / "dense/0/images", 5);
      if (!place.starts_with("co"))  // of another size: these would be refused
        for (int i = 0; i < 5; ++i)
          write_png(folder.path() / "images" / ("frame_" + padded(i) + ".png"), flat_png(9, 9));
      CHECK(frames_of(load_dataset(folder.str())) == 5);
    }
  }

  TEST_CASE("a rig decoded to folders is read as its films would be") {
    using Name = std::string (*)(int, int);
    const std::pair<Name, const char*> kinds[] = {
        {[](int c, int k) { return "cam0" + std::to_string(c) + "/images/" + padded(k) + ".png"; }, "cam00"},
        {[](int c, int k) { return "cam0" + std::to_string(c + 1) + "/frame_0" + padded(k + 1) + ".png"; },
         "cam01"},
        {[](int c, int k) { return "view" + std::to_string(5 * c + 1) + "/" + padded(k) + ".png"; },
         "view1"}};
    for (const auto& [name, first] : kinds) {
      CAPTURE(first);
      const TempFolder folder;
      write_rig(folder.path(), 4, 6, name);
      write_png(folder.path() / "masks" / padded(0), flat_png(kWide, kHigh));
      write_png(folder.path() / "images_unused/a.png", flat_png(kWide, kHigh));
      const Dataset data = load_dataset(folder.str());
      CHECK(data.format == "DyNeRF");
      REQUIRE(data.find("train")->frames.size() == 18);
      REQUIRE(data.find("test")->frames.size() == 6);
      CHECK(notes_with(data, std::string(first) + " is the test split").size() == 1);
      CHECK(notes_with(data, "every folder of pictures is a camera that stands still").size() == 1);
      for (const Split& split : data.splits)
        for (const Frame& frame : split.frames)
          CHECK(frame.time == doctest::Approx(frame.image.pixel(1, 1)[1] / 257 / 20 / 5.0));
      for (const Frame& frame : data.find("test")->frames) CHECK(frame.image.pixel(1, 1)[0] == 0);
    }
    const TempFolder folder;  // view1, view6, view11: as people count, not as letters go
    write_rig(folder.path(), 3, 2, kinds[2].first);
    const Dataset data = load_dataset(folder.str());
    CHECK(notes_with(data, "as people count: 'view1', 'view6', 'view11'").size() == 1);
    fs::remove_all(folder.path() / "view6");
    expect_error([&] { load_dataset(folder.str()); }, {"there are not as many folders of pictures as cameras",
                                                       "3, one per row", "2: 'view1', 'view11'"});
    const TempFolder both;  // and a picture of each camera, for COLMAP
    write_rig(both.path(), 3, 2, kinds[0].first);
    write_pictures(both.path() / "images", 3);
    CHECK(load_dataset(both.str()).format == "DyNeRF");
    for (const int count : {3, 5}) {  // LLFF beside a folder of something else stays LLFF
      const TempFolder llff;
      write_llff(llff.path(), true_cameras({}, count));
      write_png(llff.path() / "camera_path/a.png", flat_png(kWide, kHigh));
      CHECK(load_dataset(llff.str()).format == "LLFF");
    }
  }

  TEST_CASE("films of any usual ending and name, as many as there are cameras") {
    if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const TempFolder films;
    for (int c = 0; c < 3; ++c)
      REQUIRE(
          std::system(("ffmpeg -v error -f lavfi -i color=c=red:s=12x8:r=5 -frames:v 4 -pix_fmt yuv420p " +
                       films.str() + "/" + std::to_string(c) + ".mp4")
                          .c_str()) == 0);
    for (const auto& [before, behind] : {std::pair{"cam0", ".MP4"}, {"cam0", ".mov"}, {"0", ".mp4"}}) {
      CAPTURE(behind);
      const TempFolder folder;
      write_bytes(folder.path() / "poses_bounds.npy", npy_bytes(3, 17, llff_rows(true_cameras({}, 3))));
      for (int c = 0; c < 3; ++c)
        fs::copy_file(films.path() / (std::to_string(c) + ".mp4"),
                      folder.path() / (before + std::to_string(c) + behind));
      const Dataset data = load_dataset(folder.str(), {.pixels = false});
      CHECK(data.format == "DyNeRF");
      CHECK(data.find("train")->frames.size() == 8);
      CHECK(notes_with(data, "every film is a camera").size() == 1);
      write_text(folder.path() / (std::string(before) + "1" + behind),
                 "version https://git-lfs.github.com/spec/v1\n");
      expect_error([&] { load_dataset(folder.str()); }, {"a pointer of Git LFS", "git lfs pull"});
    }
  }

  TEST_CASE("masks are noticed in every layout, by whatever name, and are no frames") {
    using Write = void (*)(const fs::path&);
    const std::pair<Write, const char*> layouts[] = {
        {[](const fs::path& p) { write_nerfstudio(p, true_cameras({}, 5)); }, "images"},
        {[](const fs::path& p) { write_colmap_text(p, true_cameras({}, 5), kPinholeLens); }, "images"},
        {[](const fs::path& p) { write_nrnerf(p, true_cameras({}, 5)); }, "images"},
        {[](const fs::path& p) { write_llff(p, true_cameras({}, 5)); }, "images_4"},
        {[](const fs::path& p) { write_gibson(p, true_cameras({}, 5)); }, "train"},
        {[](const fs::path& p) { write_nerfies(p, true_cameras({}, 5)); }, "rgb/2x"}};
    for (const auto& [write, pictures] : layouts) {
      CAPTURE(pictures);
      const TempFolder plain;
      write(plain.path());
      CHECK(notes_with(load_dataset(plain.str()), "mask").empty());
      const std::string beside = pictures;
      for (const auto& [before, behind] :
           {std::pair<std::string, std::string>{beside + "/dynamic_mask_", ".png"},
            {beside + "/", "_mask.png"},
            {"masks/", ".png"},
            {"masks/", ".png.png"},
            {beside + "/", ".png.png"},
            {"resized_mask/2x/", ".png.png"},
            {beside + "/mask/", ".png"}}) {
        CAPTURE(before + "NAME" + behind);
        const TempFolder folder;
        write(folder.path());
        std::vector<fs::path> names;
        for (const auto& entry : fs::directory_iterator(folder.path() / pictures))
          names.push_back(entry.path());
        for (const fs::path& name : names)
          write_png(folder.path() / (before + name.stem().string() + behind), flat_png(kWide, kHigh));
        const Dataset data = load_dataset(folder.str());
        CHECK(frames_of(data) == 5);
        CHECK(notes_with(data, "masks are not used: 5 of 5 pictures have one").size() == 1);
      }
    }
  }

  TEST_CASE("masks that the data names; a mask does not stand in for a picture that is missing") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 5));
    const fs::path file = folder.path() / "transforms.json";
    replace_in(file, "\"file_path\": \"images/", "\"mask_path\": \"m/a.png\", \"file_path\": \"images/");
    CHECK(notes_with(load_dataset(folder.str()), "5 masks that the data names are not there, first 'm/a.png'")
              .size() == 1);
    write_png(folder.path() / "m/a.png", flat_png(kWide, kHigh, {255, 255, 255, 255}));
    CHECK(notes_with(load_dataset(folder.str()),
                     "masks are not used: 5 of 5 pictures have one, such as 'm/a.png', on average 100% white")
              .size() == 1);
    fs::rename(folder.path() / "images/frame_0002.png", folder.path() / "images/frame_0002.png.png");
    expect_error([&] { load_dataset(folder.str()); }, {"frame 2: the image is missing"});
  }

  TEST_CASE("paths of another machine are found where their tails lie in the folder, all in one way") {
    for (const std::string& before : {std::string("C:\\\\data\\\\scene\\\\"), std::string("/home/me/scene/"),
                                      std::string("d:/scene/"), std::string(".\\\\")}) {
      CAPTURE(before);
      const TempFolder folder;
      write_nerfstudio(folder.path(), true_cameras({}, 12));
      const std::string back = before.find('\\') != std::string::npos ? "\\\\" : "/";
      replace_in(folder.path() / "transforms.json", "images/", before + "images" + back);
      const Dataset data = load_dataset(folder.str());
      CHECK(frames_of(data) == 12);
      CHECK(notes_with(data, "paths of another machine").size() == 1);
      fs::rename(folder.path() / "images/frame_0003.png", folder.path() / "frame_0003.png");
      CHECK(frames_of(load_dataset(folder.str())) == 11);  // the others' folders were not left out
    }
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras({}, 5));
    replace_in(folder.path() / "transforms.json", "images/frame_0003.png", "/etc/passwd");
    expect_error([&] { load_dataset(folder.str()); }, {"frame 3: 'file_path' leads out of"});
  }

  TEST_CASE("pointers of Git LFS and pictures that are not read are named, with what to do") {
    const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
    const std::vector<std::string> said{"this is a pointer of Git LFS", "git lfs pull"};
    const TempFolder folder, colmap, llff;
    write_nerfstudio(folder.path(), true_cameras({}, 5));
    write_text(folder.path() / "images/frame_0001.png", pointer);
    expect_error([&] { load_dataset(folder.str()); }, said);
    write_text(folder.path() / "transforms.json", pointer);
    expect_error([&] { load_dataset(folder.str()); }, said);
    write_colmap_binary(colmap.path(), true_cameras({}, 5), kPinholeLens);
    write_text(colmap.path() / "sparse/0/cameras.bin", pointer);
    expect_error([&] { load_dataset(colmap.str()); }, said);
    write_llff(llff.path(), true_cameras({}, 5));
    for (int i = 0; i < 5; ++i)
      fs::rename(llff.path() / "images_4" / ("frame_" + padded(i) + ".png"),
                 llff.path() / "images_4" / ("frame_" + padded(i) + ".hdr"));
    expect_error([&] { load_dataset(llff.str()); },
                 {"no pictures for these cameras", "frame_0000.hdr", "oiiotool"});
    write_text(llff.path() / "poses_bounds.npy", pointer);
    expect_error([&] { load_dataset(llff.str()); }, said);

    const TempFolder exr;
    write_nerfstudio(exr.path(), true_cameras({}, 5));
    const Bytes magic{0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0};
    write_bytes(exr.path() / "images/frame_0001.png", magic);
    expect_error([&] { load_dataset(exr.str()); }, {"frame_0001.png", "header is damaged"});
    fs::rename(exr.path() / "images/frame_0001.png", exr.path() / "images/frame_0001.hdr");
    replace_in(exr.path() / "transforms.json", ".png\"", "\"");
    expect_error([&] { load_dataset(exr.str(), {.rules = {.missing = "refuse"}}); },
                 {"frame 1: the picture is of a kind that is not read", "frame_0001.hdr", "oiiotool"});
  }

  TEST_CASE("a folder of no known kind: what is in it, and what it nearly is") {
    const auto said = [](const std::string& file, const std::vector<std::string>& parts) {
      const TempFolder folder;
      write_text(folder.path() / file, "{}");
      expect_error([&] { load_dataset(folder.str()); }, parts);
    };
    for (const std::string name : {"transform.json", "Transforms.JSON", "transfroms.json"})
      said(name, {"none of them, but '" + name + "'", "'" + name + "' looks like transforms.json"});
    for (const std::string name : {"transforms_train.JSON", "transforms-train.json", "transform-train.json"})
      said(name, {"'" + name + "' looks like transforms_train.json"});
    said("poses_bounds_multipleview.npy", {"looks like poses_bounds.npy"});
    said("scene/transforms.json", {"'scene/'", "give the folder in it: "});
    said("sparse/0/cameras.bin", {"has cameras and no images file"});
    said("scene.zip", {"unpack 'scene.zip' first"});
    said("images/a.png", {"pictures without cameras: splinevox capture "});
    said("film.MP4", {"films without cameras: splinevox capture "});
    said("notes.md", {"give the folder that holds them"});
  }

  TEST_CASE("train and val without test: val is the test split where one is asked for") {
    const TempFolder folder;
    write_moving_ball(folder.path());
    fs::remove(folder.path() / "transforms_test.json");
    const Dataset test = load_dataset(folder.str(), {.splits = {"test"}});
    REQUIRE(test.splits.size() == 1);
    CHECK(test.splits[0].name == "test");
    CHECK(test.splits[0].frames.size() == 2);
    CHECK(notes_with(test, "transforms_val.json is the test split").size() == 1);
    CHECK(load_dataset(folder.str(), {.splits = {"val", "test"}}).splits.size() == 2);
    const Dataset all = load_dataset(folder.str());
    CHECK((all.find("val") && !all.find("test")));
    const TempFolder lists;
    write_nerfstudio(lists.path(), true_cameras({}, 5));
    replace_in(lists.path() / "transforms.json", "\"aabb_scale\"",
               "\"train_filenames\": [\"images/frame_0000.png\", \"images/frame_0004.png\"], "
               "\"val_filenames\": [\"images/frame_0002.png\"], \"aabb_scale\"");
    CHECK(load_dataset(lists.str(), {.splits = {"test"}}).find("test")->frames[0].name == "frame_0002");
    CHECK(load_dataset(lists.str()).find("val"));
    fs::remove(folder.path() / "transforms_val.json");
    expect_error([&] { load_dataset(folder.str(), {.splits = {"test"}}); }, {"the test split was asked for"});
  }
}

}  // namespace
