// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

#include "data/expect_error.hpp"
#include "data/layouts.hpp"
#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

/// Every layout: what is read, and the same after `convert`.
namespace {

using namespace splinevox;
using namespace splinevox::test;

const TrueLens kPlain{};
const TrueLens kUneven{11, 12, 5.5, 4.25};
const TrueLens kFish{6, 6.5, 5.5, 4.25, 0.05, -0.02, 0.004, -0.001, 0, 0, true};

/// The largest distance, in pixels, of where random points appear from where they must.
double worst_of(const Dataset& data, const Cameras& cameras) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-0.7, 0.7);
  double worst = 0;
  std::size_t frames = 0;
  for (const Split& split : data.splits)
    for (const Frame& frame : split.frames) {
      const TrueCamera& c = cameras[std::size_t(std::lround(frame.time * double(cameras.size() - 1)))];
      ++frames;
      for (int i = 0; i < 50; ++i) {
        const std::array<double, 3> p{coordinate(random), coordinate(random), coordinate(random)};
        const Projection seen = project(frame.camera, {p[0], p[1], p[2]});
        const auto [u, v] = c.see(p);
        REQUIRE(seen.depth > 0);
        worst = std::max({worst, std::abs(seen.u - u), std::abs(seen.v - v)});
        const Ray ray = camera_ray(frame.camera, u, v);  // and back: the ray goes through the point
        const Vec3d to = Vec3d{p[0], p[1], p[2]} - ray.origin;
        worst = std::max(worst, length(cross(to, ray.direction)) / length(to) * c.lens.fx);
      }
    }
  CHECK(frames == cameras.size());
  return worst;
}

std::size_t count_of(const Dataset& data, const char* split) {
  return data.find(split) ? data.find(split)->frames.size() : 0;
}

/// Reads the folder, converts it, reads that: names of the layouts, cameras and times.
Dataset check_round_trip(const TempFolder& folder, const Cameras& cameras, const std::string& format) {
  const Dataset data = load_dataset(folder.str());
  CHECK(data.format == format);
  CHECK(worst_of(data, cameras) < kPixel);
  const TempFolder out;
  convert_dataset(folder.str(), out.str() + "/converted");
  const Dataset again = load_dataset(out.str() + "/converted");
  CHECK(again.format == "NeRF / D-NeRF");
  CHECK(worst_of(again, cameras) < kPixel);
  CHECK(again.box == data.box);
  CHECK(again.time_map == data.time_map);
  REQUIRE(again.splits.size() == data.splits.size());
  for (std::size_t s = 0; s < data.splits.size(); ++s) {
    REQUIRE(again.splits[s].frames.size() == data.splits[s].frames.size());
    for (std::size_t i = 0; i < data.splits[s].frames.size(); ++i) {
      const Frame &a = data.splits[s].frames[i], &b = again.splits[s].frames[i];
      CHECK(a.time == b.time);
      CHECK(a.image == b.image);
      CHECK(a.camera.fx == b.camera.fx);
      CHECK(a.camera.cx == b.camera.cx);
      CHECK(a.camera.lens == b.camera.lens);
      CHECK(length(a.camera.position - b.camera.position) == 0);
    }
  }
  return data;
}

TEST_SUITE("data/readers") {
  TEST_CASE("nerfstudio: a lens per frame, distortion, fisheye") {
    for (const TrueLens& lens : {kPlain, kUneven, kBent, kFish}) {
      CAPTURE(lens.fisheye);
      const TempFolder folder;
      Cameras cameras = true_cameras(lens);
      for (std::size_t i = 0; i < cameras.size(); ++i) {
        cameras[i].lens.fx += 0.1 * double(i);
        cameras[i].lens.k1 *= 1 + 0.01 * double(i);
      }
      write_nerfstudio(folder.path(), cameras);
      const Dataset data = check_round_trip(folder, cameras, "nerfstudio / instant-ngp");
      CHECK(count_of(data, "train") == 14);
      CHECK(count_of(data, "test") == 2);
      CHECK(data.find("test")->frames[0].name == "frame_0004");
      CHECK_FALSE(data.has_alpha);
      const Dataset some = load_dataset(folder.str(), {.splits = {"train"}, .if_there = {"val", "test"}});
      CHECK(count_of(some, "train") == 14);
      CHECK(count_of(some, "test") == 2);
      CHECK(some.splits.size() == 2);
    }
  }

  TEST_CASE("nerfstudio: pictures of two sizes, every frame with a lens in pixels") {
    const TempFolder folder;
    Cameras cameras = true_cameras(kUneven);
    for (std::size_t i = 0; i < cameras.size(); i += 3) {
      cameras[i].lens.wide = 8;
      cameras[i].lens.high = 14;
      cameras[i].lens.cx = 3.5;
      cameras[i].lens.cy = 7.5;
    }
    write_nerfstudio(folder.path(), cameras);
    for (std::size_t i = 0; i < cameras.size(); i += 3)
      write_png(folder.path() / "images" / ("frame_" + padded(int(i)) + ".png"), flat_png(8, 14));
    const Dataset data = check_round_trip(folder, cameras, "nerfstudio / instant-ngp");
    CHECK(std::count(data.notes.begin(), data.notes.end(),
                     "train: 9 of 14 pictures are not of 8 x 14 as the first") == 1);
    for (const std::string& note : data.notes) CHECK(note.find("train has") == std::string::npos);
    const Split& train = *data.find("train");
    CHECK(train.frames[0].image.height == 14);
    CHECK(train.frames[1].image.height == kHigh);
    CHECK(load_dataset(folder.str(), {.downscale = 2}).find("train")->frames[0].camera.height == 7);
    const Dataset quarter = load_dataset(folder.str(), {.downscale = 4});
    const Frame& first = quarter.find("train")->frames[0];
    CHECK(first.image.height == 3);
    CHECK(first.camera.height == 3);
    CHECK(first.camera.cy == doctest::Approx(7.5 / 4));
    CHECK(notes_with(quarter, "train: of pictures of 8 x 14 the last 0 columns and 2 rows").size() == 1);
  }

  TEST_CASE("nerfstudio: lists of file names, several cameras at a time, times.txt") {
    const TempFolder folder;
    Cameras cameras = true_cameras(kBent);
    write_nerfstudio(folder.path(), cameras);
    const fs::path file = folder.path() / "transforms.json";
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    write_text(file,
               "{\"train_filenames\": [\"images/frame_0000.png\", \"images/frame_0015.png\"], "
               "\"test_filenames\": [\"images/frame_0007.png\"], " +
                   text.substr(1));
    const Dataset lists = load_dataset(folder.str());
    CHECK(count_of(lists, "train") == 2);
    CHECK(count_of(lists, "test") == 1);
    CHECK(lists.notes[0] == "13 of 16 frames are in none of the lists of file names and are left out");
    write_text(
        file,
        "{\"train_filenames\": [\"./images/frame_0000.png\", \"images/frame_0015.png\"], \"val_filenames\": "
        "[\"images/frame_0007.png\"], \"test_filenames\": [\"images/frame_0007.png\"], " +
            text.substr(1));
    const Dataset same = load_dataset(folder.str());
    CHECK(count_of(same, "train") == 2);
    CHECK(count_of(same, "test") == 1);
    CHECK(!same.find("val"));

    write_text(file, text);
    fs::create_directories(folder.path() / "other");
    std::string twice = text;
    twice.replace(twice.find("images/frame_0001"), 17, "other/frame_0000");
    fs::copy_file(folder.path() / "images/frame_0001.png", folder.path() / "other/frame_0000.png");
    write_text(file, twice);
    std::set<std::string> names;
    const Dataset cams = load_dataset(folder.str());
    for (const char* split : {"train", "test"})
      for (const Frame& frame : cams.find(split)->frames) names.insert(frame.name);
    CHECK(names.size() == kCameras);
    CHECK((names.contains("other_frame_0000") && names.contains("images_frame_0000") &&
           names.contains("frame_0002")));

    for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].time = double(i / 4);
    write_nerfstudio(folder.path(), cameras);
    const Dataset together = load_dataset(folder.str());
    CHECK(together.find("train")->frames[3].time == 0);
    CHECK(together.find("train")->frames.back().time == 1);
    CHECK(together.time_map(3) == 1);

    std::string list = "# name time\n";
    for (int i = 0; i < kCameras; ++i)
      list += (i % 2 ? "frame_" + padded(i) : "images/frame_" + padded(i) + ".png") + " " + exactly(100 - i) +
              "\n";
    for (std::size_t at; (at = text.find("\"time\"")) != std::string::npos;)
      text.erase(at, text.find(", ", at) + 2 - at);
    write_text(file, text);
    write_text(folder.path() / "times.txt", list);
    const Dataset listed = load_dataset(folder.str());
    CHECK(listed.find("train")->frames[0].name == "frame_0015");
    CHECK(listed.notes[0] == "times are those of times.txt");
    fs::remove(folder.path() / "times.txt");
    CHECK(load_dataset(folder.str()).notes[0] ==
          "the data has no times, so they are those in the names: 'images/frame_0000.png' is at 0, "
          "'images/frame_0015.png' at 15 (the only number that counts up) (a guess: --times none if they are "
          "of one moment)");
  }

  TEST_CASE("what is missing is counted: a tenth is left out with a note, more only if told to") {
    const TempFolder folder;
    write_nerfstudio(folder.path(), true_cameras(kBent));
    const auto all = [&](const std::string& rule) {
      const Dataset data = load_dataset(folder.str(), {.rules = {.missing = rule}});
      return std::pair(count_of(data, "train") + count_of(data, "test"), data.notes);
    };
    CHECK(all("refuse").first == kCameras);
    fs::remove(folder.path() / "images/frame_0003.png");
    const auto [count, notes] = all("");
    CHECK(count == kCameras - 1);
    CHECK(notes[0].find("1 of 16 pictures are missing and left out") == 0);
    expect_error([&] { all("refuse"); }, {"frame 3: the image is missing", "--missing skip"});
    expect_error([&] { all("sometimes"); }, {"--missing: there is no such rule"});
    fs::remove(folder.path() / "images/frame_0009.png");
    expect_error([&] { all(""); }, {"frame 3: the image is missing", "2 of 16 frames are like this",
                                    "--missing skip to go on without 2 of 16"});
    CHECK(all("skip").first == kCameras - 2);
    const fs::path file = folder.path() / "transforms.json";
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const std::size_t at = text.find("[[", text.find("transform_matrix"));
    text.replace(at, text.find(',', at) - at, "[[1e300");
    write_text(file, text);
    const auto [left, said] = all("skip");
    CHECK(left == kCameras - 3);
    CHECK(said[1].find("1 of 16 frames have no usable camera and are left out") == 0);
  }

  TEST_CASE("a rig's first and last moment always train, and so do those of a short film") {
    for (const int count : {3, 5, 6, 7, 13, 16}) {
      const TempFolder folder;
      write_nerfstudio(folder.path(), true_cameras(kBent, count));
      const Dataset data = load_dataset(folder.str());
      const Split& train = *data.find("train");
      CHECK(train.frames.front().time == 0);
      CHECK(train.frames.back().time == 1);
      if (const Split* test = data.find("test"); test)
        for (const Frame& frame : test->frames) CHECK((frame.time > 0 && frame.time < 1));
      CHECK((data.find("test") != nullptr) == (count >= 5));
    }
  }

  TEST_CASE("NeRFlow: degrees, world to camera, step numbers") {
    const TempFolder folder;
    const Cameras cameras = true_cameras(kPlain);
    write_gibson(folder.path(), cameras);
    const Dataset data = check_round_trip(folder, cameras, "NeRFlow (Gibson)");
    CHECK(data.time_map.scale == doctest::Approx(1.0 / 45));
  }

  TEST_CASE("COLMAP: text and binary models of every lens") {
    const TrueLens square{11, 11, 5.5, 4.25}, radial1{11, 11, 5.5, 4.25, -0.12},
        radial2{11, 11, 5.5, 4.25, -0.12, 0.03}, bent{11, 12, 5.5, 4.25, -0.12, 0.03, 0, 0, 0.002, -0.003},
        fish1{6, 6, 5.5, 4.25, 0.05, 0, 0, 0, 0, 0, true},
        fish2{6, 6, 5.5, 4.25, 0.05, -0.02, 0, 0, 0, 0, true};
    const std::pair<TrueLens, ColmapLens> lenses[] = {
        {square, {"SIMPLE_PINHOLE", 0, {11, 5.5, 4.25}}},
        {kUneven, {"PINHOLE", 1, {11, 12, 5.5, 4.25}}},
        {radial1, {"SIMPLE_RADIAL", 2, {11, 5.5, 4.25, -0.12}}},
        {radial2, {"RADIAL", 3, {11, 5.5, 4.25, -0.12, 0.03}}},
        {bent, {"OPENCV", 4, {11, 12, 5.5, 4.25, -0.12, 0.03, 0.002, -0.003}}},
        {kFish, {"OPENCV_FISHEYE", 5, {6, 6.5, 5.5, 4.25, 0.05, -0.02, 0.004, -0.001}}},
        {fish1, {"SIMPLE_RADIAL_FISHEYE", 8, {6, 5.5, 4.25, 0.05}}},
        {fish2, {"RADIAL_FISHEYE", 9, {6, 5.5, 4.25, 0.05, -0.02}}}};
    for (const auto& [lens, stored] : lenses) {
      CAPTURE(stored.name);
      const Cameras cameras = true_cameras(lens);
      const TempFolder text, binary;
      write_colmap_text(text.path(), cameras, stored);
      write_colmap_binary(binary.path(), cameras, stored);
      const Dataset data = check_round_trip(text, cameras, "COLMAP");
      CHECK(worst_of(load_dataset(binary.str()), cameras) < kPixel);
      REQUIRE(data.box);
      CHECK(data.box->lo.x == doctest::Approx(-1.095));
      CHECK(data.box == load_dataset(binary.str()).box);
    }
  }

  TEST_CASE("Nerfies: scaled world, halved pictures, val_ids as test split") {
    const TempFolder folder;
    const Cameras cameras = true_cameras(kBent);
    write_nerfies(folder.path(), cameras);
    const Dataset data = check_round_trip(folder, cameras, "Nerfies / HyperNeRF");
    CHECK(count_of(data, "test") == 3);
    CHECK(data.box);
    std::vector<double> points;
    for (int i = 0; i < 30; ++i)
      for (int k = 0; k < 3; ++k) points.push_back(4 * (0.1 * i - 1.5) + k + 1);
    write_bytes(folder.path() / "points.npy", npy_bytes(30, 3, points, "<f4"));
    CHECK(load_dataset(folder.str()).box->lo.y == doctest::Approx(-1.5 - 0.145));
  }

  TEST_CASE("LLFF: turned axes, smaller pictures; NR-NeRF: axes as they are") {
    const Cameras cameras = true_cameras(kPlain);
    const TempFolder llff, nrnerf;
    write_llff(llff.path(), cameras);
    check_round_trip(llff, cameras, "LLFF");
    write_nrnerf(nrnerf.path(), cameras);
    const Dataset data = check_round_trip(nrnerf, cameras, "NR-NeRF");
    CHECK(data.box);
    // Every point between the depth bounds that a camera sees lies in the box.
    for (const Frame& f : data.find("train")->frames)
      for (const double depth : {1.5, 5.0}) {
        const Ray ray = camera_ray(f.camera, 12, 8);
        const Vec3 p =
            cast<float>(ray.origin + depth / -dot(ray.direction, f.camera.axes[2]) * ray.direction);
        for (int axis = 0; axis < 3; ++axis)
          CHECK((p[axis] >= data.box->lo[axis] - 1e-4f && p[axis] <= data.box->hi[axis] + 1e-4f));
      }
  }

  TEST_CASE("D-NeRF: our own fields survive, a second conversion changes nothing") {
    const TempFolder folder, out;
    write_moving_ball(folder.path());
    convert_dataset(folder.str(), out.str() + "/a");
    convert_dataset(out.str() + "/a", out.str() + "/b");
    const auto text = [&](const char* path) {
      std::ifstream in(out.path() / path);
      return std::string((std::istreambuf_iterator<char>(in)), {});
    };
    CHECK(text("a/transforms_test.json").size() > 500);
    CHECK(text("a/transforms_test.json") == text("b/transforms_test.json"));
    const Dataset data = load_dataset(folder.str()), again = load_dataset(out.str() + "/a");
    CHECK(again.has_alpha);
    CHECK(data.find("val")->frames[1].image == again.find("val")->frames[1].image);
    expect_error([&] { convert_dataset(folder.str(), out.str() + "/a"); },
                 {"/a: there is something of that name already", "another folder for --out"});
    expect_error([&] { convert_dataset(folder.str(), folder.str() + "/inside"); },
                 {"the output lies within the data set"});
    CHECK_FALSE(fs::exists(folder.path() / "inside"));
  }

  TEST_CASE(
      "H14: a scene in coordinates of a map is brought near the origin, cameras to a unit of rounding "
      "there") {
    const TempFolder folder, out;
    write_moving_ball(folder.path());
    const Vec3d away{500'000, -4'000'000, 250.5};
    convert_dataset(folder.str(), out.str() + "/map", {}, {.shift = away});
    convert_dataset(out.str() + "/map", out.str() + "/near", {}, {.shift = -1.0 * away, .scale = 2});
    const Dataset plain = load_dataset(folder.str()), map = load_dataset(out.str() + "/map"),
                  near = load_dataset(out.str() + "/near");
    for (const char* split : {"train", "val", "test"})
      for (std::size_t i = 0; i < plain.find(split)->frames.size(); ++i) {
        const Camera &p = plain.find(split)->frames[i].camera, &m = map.find(split)->frames[i].camera,
                     &n = near.find(split)->frames[i].camera;
        for (int axis = 0; axis < 3; ++axis) {
          CHECK(m.position[axis] == p.position[axis] + away[axis]);
          CHECK(std::abs(n.position[axis] / 2 - p.position[axis]) <= 4e6 * 0x1p-53);
        }
        CHECK(n.axes == p.axes);
      }
  }

  TEST_CASE("DyNeRF: films by ffmpeg, the first the test view") {
    if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const TempFolder folder;
    const Cameras places = true_cameras(kPlain, 3);
    write_bytes(folder.path() / "poses_bounds.npy", npy_bytes(3, 17, llff_rows(places)));
    for (int i = 0; i < 3; ++i) {
      const std::string film = folder.str() + "/cam0" + std::to_string(i) + ".mp4";
      REQUIRE(std::system(("ffmpeg -v error -f lavfi -i color=c=" + std::string(i == 0 ? "red" : "blue") +
                           ":s=12x8:r=5 -frames:v 5 -pix_fmt yuv420p " + film)
                              .c_str()) == 0);
    }
    const Dataset data = load_dataset(folder.str());
    CHECK(data.format == "DyNeRF");
    REQUIRE(count_of(data, "train") == 10);
    REQUIRE(count_of(data, "test") == 5);
    CHECK(data.find("test")->frames[4].name == "cam00_0004");
    CHECK(data.find("test")->frames[1].time == 0.25);
    const auto red = data.find("test")->frames[2].image.pixel(3, 3);
    CHECK(red[0] > 60000);
    CHECK(red[2] < 5000);
    CHECK(data.find("train")->frames[7].image.pixel(3, 3)[2] > 60000);
    const TempFolder out;
    convert_dataset(folder.str(), out.str() + "/converted");
    const Dataset again = load_dataset(out.str() + "/converted");
    CHECK(again.find("train")->frames[6].image == data.find("train")->frames[6].image);
    CHECK(again.find("train")->frames[6].camera.fx == 11);
    CHECK_FALSE(load_dataset(folder.str(), {.pixels = false}).find("train")->frames[0].image.has_values());
    CHECK(load_dataset(folder.str(), {.downscale = 2}).find("test")->frames[0].image.width == 6);
    write_bytes(folder.path() / "cam02.mp4", {1, 2, 3});
    expect_error([&] { load_dataset(folder.str()); }, {"cam02.mp4: this is no film that ffprobe can read"});
    fs::remove(folder.path() / "cam02.mp4");
    expect_error([&] { load_dataset(folder.str()); },
                 {"there are not as many films as cameras", "3, one per row"});
  }
}

}  // namespace
