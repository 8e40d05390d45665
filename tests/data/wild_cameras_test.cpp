// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

#include "data/expect_error.hpp"
#include "data/layouts.hpp"
#include "math/camera.hpp"
#include "splinevox/data/scene.hpp"

/// Lenses and matrices as people's own programs write them.
namespace {

using namespace splinevox;
using namespace splinevox::test;
using Matrix = std::array<double, 16>;

/// The largest distance, in pixels, of where points near the origin appear from where they must. Frames are
/// those of `cameras` in the order of time.
double worst_of(const Dataset& data, const Cameras& cameras) {
  double worst = 0;
  for (const Split& split : data.splits)
    for (const Frame& frame : split.frames) {
      const TrueCamera& c = cameras[std::size_t(std::lround(frame.time * double(cameras.size() - 1)))];
      for (const std::array<double, 3>& p :
           {std::array{0.3, -0.2, 0.5}, {-0.6, 0.1, -0.4}, {0.1, 0.6, 0.2}}) {
        const Projection seen = project(frame.camera, {p[0], p[1], p[2]});
        const auto [u, v] = c.see(p);
        worst = std::max({worst, std::abs(seen.u - u), std::abs(seen.v - v)});
      }
    }
  return worst;
}

std::size_t count_notes(const Dataset& data, const std::string& text) {
  return std::size_t(std::count_if(data.notes.begin(), data.notes.end(), [&](const std::string& note) {
    return note.find(text) != std::string::npos;
  }));
}

/// One transforms.json with `head`, and frames of `cameras` whose matrices and further fields are given.
void write_frames(const fs::path& folder, const Cameras& cameras, const std::string& head,
                  const std::function<std::string(const Matrix&)>& matrix = matrix_text,
                  const std::string& fields = "") {
  write_pictures(folder / "images", int(cameras.size()));
  std::vector<std::string> frames;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::string frame = frame_text("images/frame_" + padded(int(i)) + ".png", exactly(cameras[i].time),
                                   matrix(cameras[i].to_world));
    frames.push_back(frame.insert(1, fields));
  }
  write_text(folder / "transforms.json", transforms_text(frames, head));
}

/// Columns and rows times -1.
Matrix flipped(Matrix m, std::initializer_list<std::size_t> columns,
               std::initializer_list<std::size_t> rows = {}) {
  for (const std::size_t c : columns)
    for (std::size_t r = 0; r < 3; ++r) m[4 * r + c] *= -1;
  for (const std::size_t r : rows)
    for (std::size_t c = 0; c < 4; ++c) m[4 * r + c] *= -1;
  return m;
}

const std::string kHead = "\"fl_x\": 11, \"fl_y\": 11, \"cx\": 6, \"cy\": 4,";
const Cameras kTen = true_cameras({}, 10);

TEST_SUITE("data/wild_cameras") {
  TEST_CASE("COLMAP: lenses of 3.12 to 4.2 that are known ones, and old ones whose further numbers are 0") {
    const TrueLens plain{11, 11, 5.5, 4.25}, uneven{11, 12, 5.5, 4.25},
        bent{11, 12, 5.5, 4.25, -0.12, 0.03, -0.004, 0, 0.002, -0.003},
        fish{6, 6.5, 5.5, 4.25, 0.05, -0.02, 0.004, -0.001, 0, 0, true},
        round{6, 6, 5.5, 4.25, 0, 0, 0, 0, 0, 0, true}, oval{6, 6.5, 5.5, 4.25, 0, 0, 0, 0, 0, 0, true};
    const std::pair<TrueLens, ColmapLens> lenses[] = {
        {bent, {"FULL_OPENCV", 6, {11, 12, 5.5, 4.25, -0.12, 0.03, 0.002, -0.003, -0.004, 0, 0, 0}}},
        {uneven, {"FOV", 7, {11, 12, 5.5, 4.25, 0}}},
        {fish, {"THIN_PRISM_FISHEYE", 10, {6, 6.5, 5.5, 4.25, 0.05, -0.02, 0, 0, 0.004, -0.001, 0, 0}}},
        {fish,
         {"RAD_TAN_THIN_PRISM_FISHEYE",
          11,
          {6, 6.5, 5.5, 4.25, 0.05, -0.02, 0.004, -0.001, 0, 0, 0, 0, 0, 0, 0, 0}}},
        {plain, {"SIMPLE_DIVISION", 12, {11, 5.5, 4.25, 0}}},
        {uneven, {"DIVISION", 13, {11, 12, 5.5, 4.25, 0}}},
        {round, {"SIMPLE_FISHEYE", 14, {6, 5.5, 4.25}}},
        {oval, {"FISHEYE", 15, {6, 6.5, 5.5, 4.25}}},
        {uneven, {"EUCM", 16, {11, 12, 5.5, 4.25, 0, 1.2}}}};
    for (const auto& [lens, stored] : lenses) {
      CAPTURE(stored.name);
      const Cameras cameras = true_cameras(lens);
      const TempFolder text, binary;
      write_colmap_text(text.path(), cameras, stored);
      write_colmap_binary(binary.path(), cameras, stored);
      write_bytes(binary.path() / "sparse/0/rigs.bin", {1, 2, 3});  // beside the model, not of it
      write_bytes(binary.path() / "sparse/0/frames.bin", {1, 2, 3});
      CHECK(worst_of(load_dataset(text.str()), cameras) < 1e-6);
      CHECK(worst_of(load_dataset(binary.str()), cameras) < 1e-6);
    }
  }

  TEST_CASE("COLMAP: a lens that is none of ours is named, with how to convert it") {
    const std::pair<ColmapLens, std::vector<std::string>> lenses[] = {
        {{"FULL_OPENCV", 6, {11, 12, 5.5, 4.25, 0, 0, 0, 0, 0, 0.1, 0, 0}},
         {"FULL_OPENCV is not supported", "parameter 10 is 0.1", "image_undistorter"}},
        {{"SIMPLE_DIVISION", 12, {11, 5.5, 4.25, -0.1}},
         {"SIMPLE_DIVISION is not supported", "parameter 4 is -0.1", "image_undistorter"}},
        {{"EUCM", 16, {11, 11, 5.5, 4.25, 0.6, 1.2}}, {"EUCM is not supported", "parameter 5 is 0.6"}},
        {{"EQUIRECTANGULAR", 17, {12, 8}},
         {"EQUIRECTANGULAR is not supported", "cut it into PINHOLE views"}}};
    for (const auto& [lens, said] : lenses) {
      const TempFolder text, binary;
      write_colmap_text(text.path(), kTen, lens);
      write_colmap_binary(binary.path(), kTen, lens);
      expect_error([&] { load_dataset(text.str()); }, said);
      expect_error([&] { load_dataset(binary.str()); }, said);
    }
  }

  TEST_CASE("transforms: models of lenses by their names") {
    const TempFolder folder;
    write_frames(folder.path(), kTen, kHead + "\"camera_model\": \"EQUIRECTANGULAR\",");
    expect_error([&] { load_dataset(folder.str()); },
                 {"'camera_model' is not supported", "--camera-type equirectangular"});
    const Cameras fish = true_cameras({11, 11, 6, 4, 0, 0, 0, 0, 0, 0, true}, 10);
    write_frames(folder.path(), fish, kHead + "\"camera_model\": \"SIMPLE_FISHEYE\",");
    CHECK(worst_of(load_dataset(folder.str()), fish) < 1e-6);
  }

  TEST_CASE("transforms: a lens as a matrix, for the file or for each frame") {
    const Cameras cameras = true_cameras({11, 12, 5.5, 4.25}, 10);
    for (const std::string matrix : {"[[11, 0, 5.5], [0, 12, 4.25], [0, 0, 1]]",
                                     "[11, 0, 5.5, 0, 12, 4.25, 0, 0, 1]", "[11, 12, 5.5, 4.25]"})
      for (const std::string name :
           {"K", "intrinsics", "camera_intrinsics", "intrinsic", "intrinsic_matrix", "camera_matrix"}) {
        CAPTURE(name);
        const TempFolder file, frame;
        const std::string field = "\"" + name + "\": " + matrix + ", ";
        write_frames(file.path(), cameras, field);
        write_frames(frame.path(), cameras, "\"camera_angle_x\": 0.1,", matrix_text, field);
        CHECK(worst_of(load_dataset(file.str()), cameras) < 1e-6);
        CHECK(worst_of(load_dataset(frame.str()), cameras) < 1e-6);
        for (const TempFolder* folder : {&file, &frame})
          CHECK(count_notes(load_dataset(folder->str()), "is not read") == 0);
      }
    const std::pair<const char*, const char*> bad[] = {
        {"[[0.9, 0, 0.5], [0, 0.9, 0.5], [0, 0, 1]]", "'K' is not in pixels"},
        {"[[11, 0.5, 5.5], [0, 12, 4.25], [0, 0, 1]]", "'K' has skew"},
        {"[[11, 0, 0], [0, 12, 0], [5.5, 4.25, 1]]", "'K' is no matrix of a lens"}};
    for (const auto& [matrix, said] : bad) {
      const TempFolder folder;
      write_frames(folder.path(), cameras, std::string("\"K\": ") + matrix + ",");
      expect_error([&] { load_dataset(folder.str()); }, {said});
    }
    const TempFolder both;
    write_frames(both.path(), kTen, "\"K\": [[11, 0], [0, 12]], " + kHead);
    CHECK(worst_of(load_dataset(both.str()), kTen) < 1e-6);
    CHECK(count_notes(load_dataset(both.str()), "'K' is not read, because there is 'fl_x'") == 1);
  }

  TEST_CASE("transforms: a field one letter off a known one is named") {
    const TempFolder folder;
    write_frames(folder.path(), kTen, "\"f1_x\": 11,");
    expect_error([&] { load_dataset(folder.str()); },
                 {"there is no focal length", "'f1_x', which may be meant for 'fl_x'"});
    write_frames(folder.path(), kTen,
                 kHead + "\"K1\": 0.1, \"frame\": 3, \"camera-model\": \"OPENCV\", \"k6\": 0.2,");
    const Dataset data = load_dataset(folder.str());
    CHECK(count_notes(data, "transforms.json: 'K1' is not read; 'k1' may be meant") == 1);
    CHECK(count_notes(data, "'camera-model' is not read; 'camera_model' may be meant") == 1);
    CHECK(count_notes(data, "'k6' is not read: undistort") == 1);
    CHECK(count_notes(data, "is not read") == 3);
    std::string text;
    {
      std::ifstream in(folder.path() / "transforms.json");
      text.assign((std::istreambuf_iterator<char>(in)), {});
    }
    text.replace(text.find("transform_matrix"), 16, "transfrom_matrix");
    write_text(folder.path() / "transforms.json", text);
    expect_error([&] { load_dataset(folder.str()); },
                 {"'transform_matrix' is missing", "'transfrom_matrix', which may be meant"});
    write_text(folder.path() / "transforms.json", "{\"frame\": []}");
    expect_error([&] { load_dataset(folder.str()); },
                 {"'frames' is missing", "but 'frame', which may be meant"});
    const TempFolder plain;
    write_nerfstudio(plain.path(), kTen);
    CHECK(count_notes(load_dataset(plain.str()), "is not read") == 0);
  }

  TEST_CASE("matrices: three rows; a last row 0 0 0 w that is the same in all") {
    const auto rows = [](double all, double last) {
      return [=](Matrix m) {
        for (std::size_t i = 0; i < 12; ++i) m[i] *= all;
        m[15] = last;
        return matrix_text(m);
      };
    };
    const TempFolder three, divided, kept, differs;
    write_frames(three.path(), kTen, kHead, [](const Matrix& m) {
      const std::string text = matrix_text(m);
      return text.substr(0, text.rfind(", [")) + "]";
    });
    const Dataset read = load_dataset(three.str());
    CHECK(worst_of(read, kTen) < 1e-6);
    write_frames(divided.path(), kTen, kHead, rows(0.00118, 0.00118));
    CHECK(worst_of(load_dataset(divided.str()), kTen) < 1e-6);
    CHECK(count_notes(load_dataset(divided.str()), "0 0 0 0.00118: all were divided by it") == 1);
    write_frames(kept.path(), kTen, kHead, rows(1, 0.00118));
    CHECK(worst_of(load_dataset(kept.str()), kTen) < 1e-6);
    CHECK(count_notes(load_dataset(kept.str()), "positions are taken as they stand") == 1);
    double w = 0.5;
    write_frames(differs.path(), kTen, kHead, [&](const Matrix& m) {
      w += 0.1;
      return rows(w, w)(m);
    });
    expect_error([&] { load_dataset(differs.str()); },
                 {"frame 0: 'transform_matrix' has a wrong last row", "its last number is a scale"});
    write_frames(differs.path(), kTen, kHead, rows(0.25, 1));
    expect_error([&] { load_dataset(differs.str()); },
                 {"has a scale", "divide its first three columns by 0.25"});
  }

  TEST_CASE("matrices: which axis is mirrored, as far as the cameras together tell") {
    const auto said = [](std::initializer_list<std::size_t> columns, std::initializer_list<std::size_t> rows,
                         const std::string& hint) {
      const TempFolder folder;
      write_frames(folder.path(), kTen, kHead,
                   [&](const Matrix& m) { return matrix_text(flipped(m, columns, rows)); });
      expect_error([&] { load_dataset(folder.str()); }, {"mirrors the camera", "10 of 10 frames", hint});
    };
    said({2}, {}, "the third column seems to point forwards: negate it");
    said({1}, {}, "the second column seems to point down: negate it");
    said({}, {1}, "the world seems to be left-handed (Unity, Unreal)");
    said({0}, {}, "the first column points left: negate it");
    said({0, 1, 2}, {}, "point down and forwards (OpenCV) in a left-handed world");
    const TempFolder parallel;
    write_frames(parallel.path(), kTen, kHead, [&](const Matrix& m) {
      return matrix_text({1, 0, 0, m[3], 0, 1, 0, m[7], 0, 0, -1, m[11], 0, 0, 0, 1});
    });
    expect_error([&] { load_dataset(parallel.str()); }, {"mirrors the camera", "do not tell which"});
  }

  TEST_CASE("lenses that are hardly real, and focal lengths given twice, get one note") {
    const auto notes = [](const std::string& head) {
      const TempFolder folder;
      write_frames(folder.path(), kTen, head);
      const Dataset data = load_dataset(folder.str());
      return std::pair(count_notes(data, "usual lens"), count_notes(data, "do not agree"));
    };
    CHECK(notes(kHead) == std::pair<std::size_t, std::size_t>(0, 0));
    CHECK(notes("\"fl_x\": 11, \"camera_angle_x\": 0.999,") == std::pair<std::size_t, std::size_t>(0, 0));
    for (const std::string odd : {"\"fl_x\": 11, \"fl_y\": 229,", "\"fl_x\": 1e5,", "\"fl_x\": 0.4,",
                                  "\"fl_x\": 11, \"fl_y\": 23,", "\"camera_angle_x\": 3.1,"})
      CHECK(notes(odd).first == 2);  // of train and of test
    CHECK(notes("\"fl_x\": 12, \"camera_angle_x\": 0.999,") == std::pair<std::size_t, std::size_t>(0, 2));
    CHECK(notes("\"fl_x\": 1200, \"camera_angle_x\": 0.999,") == std::pair<std::size_t, std::size_t>(2, 2));
    const TempFolder folder;
    write_frames(folder.path(), kTen, "\"fl_x\": 1200, \"camera_angle_x\": 0.999,");
    CHECK(count_notes(
              load_dataset(folder.str()),
              "train: in 9 of 9 frames fl_x and camera_angle_x do not agree: 0.57 degrees and 57; fl_x is "
              "used, though the field of view is then 0.57 x 0.38 degrees") == 1);
    const TempFolder fish;
    write_frames(fish.path(), kTen, "\"fl_x\": 6, \"fl_y\": 13, \"camera_model\": \"FISHEYE\",");
    CHECK(count_notes(load_dataset(fish.str()), "usual lens") == 0);
  }
}

}  // namespace
