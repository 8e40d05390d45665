// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "data/layouts.hpp"
#include "data/spoil.hpp"

/// What each reader says of broken input; docs/data.md has these as a table.
namespace {

using namespace splinevox;
using namespace splinevox::test;

const Cameras kFew = true_cameras({}, 10);
const ColmapLens kOpencv{"OPENCV", 4, {11, 12, 5.5, 4.25, -0.12, 0.03, 0.002, -0.003}};

TEST_SUITE("data/bad_layouts") {
  TEST_CASE("nerfstudio") {
    const Set set([](const fs::path& p) { write_nerfstudio(p, kFew); });
    const std::string file = "transforms.json";
    set.refuse(file, "\"camera_model\": \"OPENCV\"", "\"camera_model\": \"EQUIRECTANGULAR\"",
               {"transforms.json, frame 0: 'camera_model' is not supported", "'EQUIRECTANGULAR'"});
    set.refuse(file, "\"k1\": 0", "\"k1\": -3",
               {"frame 0: the lens distortion cannot be undone in all of the picture", "none at pixel"});
    set.refuse(file, "\"k1\": 0", "\"k1\": 1e9",
               {"frame 0: a coefficient of the distortion is out of range", "1e+09"});
    set.refuse(
        file, "\"w\": 12", "\"w\": 24",
        {"frame 0: 'w' is not the picture's size", "expected: 12, as in the image file", "got:      24"});
    set.refuse(file, "\"time\": 1,", "", {"frame 1: 'time' is missing", "9 of 10 frames with 'time'"});
    set.refuse(file, "images/frame_0003.png", "images/frame_0333.png",
               {"frame 3: the image is missing", "'images/frame_0333.png'"});
    set.refuse(file, "\"aabb_scale\"", "\"train_filenames\": [\"images/none.png\"], \"aabb_scale\"",
               {"no frame is in 'train_filenames'"});
    set.refuse(file, "\"aabb_scale\"", "\"train_filenames\": 3, \"aabb_scale\"",
               {"'train_filenames' is not a list"});
    set.refuse(file, "\"aabb_scale\"", "\"scene_box\": [[1, 0, 0], [0, 1, 1]], \"aabb_scale\"",
               {"'scene_box' is no box"});
    write_text(set.path() / "times.txt", "frame_0000.png soon\n");
    std::string untimed = text_of(set.path() / file);
    for (std::size_t at; (at = untimed.find("\"time\"")) != std::string::npos;)
      untimed.erase(at, untimed.find(", ", at) + 2 - at);
    set.replace(file, untimed, {"times.txt, line 1: this is no time", "'frame_0000.png soon'"});
    write_text(set.path() / "times.txt", "frame_0000.png 1\n\nframe_0000.png 2\n");
    set.replace(file, untimed, {"times.txt, line 3: this picture has a time already"});
    write_text(set.path() / "times.txt", "frame_0000.png 1\n");
    set.replace(file, untimed, {"times.txt: a picture has no time", "none for 'images/frame_0001.png'"});
    set.damage(file, 150);
  }

  TEST_CASE("NeRFlow") {
    const Set set([](const fs::path& p) { write_gibson(p, kFew); });
    const std::string file = "transform_train.json", good = text_of(set.path() / file);
    const std::size_t angle = good.find("camera_angle_x\": ") + 17;
    const std::string stated = good.substr(angle, good.find(',', angle) - angle);
    set.refuse(file, stated, "0.69",
               {"'camera_angle_x' is no field of view in degrees", "it looks like radians"});
    set.refuse(file, stated, "190", {"'camera_angle_x' is no field of view in degrees", "got:      190"});
    set.refuse(file, "\"timestep\": 3", "\"timestep\": \"3\"",
               {"frame 1: 'timestep' is not a number", "the text '3'"});
    set.refuse(file, "\"timestep\": 3, ", "", {"frame 1: 'timestep' is missing"});
    set.refuse(file, "train/frame_0002.png", "../frame_0002.png",
               {"frame 2: 'file_path' leads out of the data set's folder"});
    set.refuse(file, "\"transform_matrix\": [[", "\"transform_matrix\": [[1, 2, 3, 4], [",
               {"frame 0: 'transform_matrix' has the wrong shape"});
    set.damage(file, 100);
  }

  TEST_CASE("COLMAP, text") {
    const Set set([](const fs::path& p) { write_colmap_text(p, kFew, kOpencv); });
    const std::string cameras = "sparse/0/cameras.txt", images = "sparse/0/images.txt";
    set.refuse(cameras, "OPENCV", "FULL_OPENCV",
               {"cameras.txt, line 2: the line is too short", "a parameter of the camera"});
    set.refuse(cameras, "OPENCV", "FOV",
               {"images.txt, image frame_0000.png: the camera model FOV is not supported",
                "colmap image_undistorter"});
    set.refuse(cameras, "OPENCV", "OPENVC",
               {"cameras.txt, line 2: there is no such camera model", "'OPENVC'"});
    set.refuse(cameras, " 12 8 ", " 12 x ",
               {"cameras.txt, line 2: this is not a number", "the height", "'x'"});
    set.refuse(cameras, " 12 8 ", " 8 8 ",
               {"the picture has another shape than its camera", "8 x 8 or the same scaled", "12 x 8"});
    set.refuse(images, " 1 frame_0002.png", " 7 frame_0002.png",
               {"image frame_0002.png: there is no such camera", "got:      7"});
    set.refuse(images, "frame_0000.png", "gone.png",
               {"images.txt, image gone.png: the image is missing", "images/gone.png"});
    set.replace(images, "# nothing\n", {"images.txt: the model has no images"});
    set.replace(images, "1 0 0 0 0 0 0 0 1 frame_0000.png\n\n",
                {"image frame_0000.png: the rotation is no quaternion", "length 0"});
    set.replace(images, "1 nan 0 0 0 0 0 0 1 frame_0000.png\n\n",
                {"images.txt, line 1: this is not a number", "'nan'"});
    set.replace(images, "1 1 0 0 0 0 0 0 1 ../../../../../../../../etc/passwd\n\n",
                {"'file_path' leads out of the data set's folder"});
    set.damage(images, 100);
    fs::remove_all(set.path() / "images");
    set.expect({"images.txt: the pictures are not there", "'images/frame_0000.png'",
                "copy the pictures beside the model"});
  }

  TEST_CASE("COLMAP, binary") {
    const Set set([](const fs::path& p) { write_colmap_binary(p, kFew, kOpencv); });
    const std::string cameras = "sparse/0/cameras.bin", images = "sparse/0/images.bin",
                      points = "sparse/0/points3D.bin";
    const std::string c = text_of(set.path() / cameras), i = text_of(set.path() / images),
                      p = text_of(set.path() / points);
    set.replace(cameras, c.substr(0, c.size() - 4),
                {"cameras.bin, byte 88: the file ends early", "8 bytes more"});
    set.replace(cameras, c + "x", {"cameras.bin, byte 96: there is more in the file than its entries"});
    set.replace(cameras, std::string(c).replace(12, 1, "\x2a"),
                {"there is no such camera model", "got:      42"});
    set.replace(images, "\xff\xff\xff\xff\xff\xff\xff\x7f" + i.substr(8),
                {"images.bin, byte 8: the file is shorter than the number of its entries asks for"});
    set.replace(images, i.substr(0, 80), {"images.bin, byte 8: the file is shorter"});
    set.replace(images, std::string(i).replace(12, 8, "\xff\xff\xff\xff\xff\xff\xff\x7f"),
                {"a rotation is not finite"});
    set.replace(points, p.substr(0, p.size() - 1), {"points3D.bin", "the file"});
    for (const std::string& file : {cameras, images, points}) set.damage(file, 100);
  }

  TEST_CASE("Nerfies") {
    const Set set([](const fs::path& p) { write_nerfies(p, kFew); });
    const std::string camera = "camera/000_0003.json";
    set.refuse(camera, "\"skew\": 0.0", "\"skew\": 0.1",
               {"camera/000_0003.json: a lens with skew is not supported"});
    set.refuse(camera, "\"orientation\": [[", "\"orientation\": [[1, 2, 3], [",
               {"camera/000_0003.json: 'orientation' is not a rotation"});
    set.refuse(camera, "\"image_size\": [24, 16]", "\"image_size\": [24]", {"'image_size' is not 2 numbers"});
    set.refuse(camera, "\"focal_length\"", "\"focal\"", {"'focal_length' is missing"});
    set.refuse(camera, "\"image_size\": [24, 16]", "\"image_size\": [16, 24]",
               {"the picture has another shape than its camera"});
    set.refuse("dataset.json", "\"000_0001\"", "\"../000_0001\"",
               {"'train_ids' holds something that is no name of a frame"});
    set.refuse("dataset.json", "\"000_0001\"", "\"000_0099\"", {"000_0099.json: the file does not exist"});
    set.refuse("metadata.json", "\"000_0001\"", "\"000_0991\"",
               {"metadata.json: there is nothing about frame '000_0001'"});
    set.refuse("metadata.json", "\"warp_id\": 1", "\"id\": 1",
               {"metadata.json, frame 000_0001: 'warp_id' is missing"});
    set.refuse("scene.json", "\"scale\": 0.25", "\"scale\": 0", {"scene.json: 'scale' is out of range"});
    write_bytes(set.path() / "points.npy", npy_bytes(30, 2, std::vector<double>(60, 1.0)));
    set.expect({"points.npy: these are no points", "3 columns", "got:      2"});
    fs::remove(set.path() / "points.npy");
    set.damage(camera, 100);
    fs::remove_all(set.path() / "rgb");
    set.expect({"rgb: there are no pictures"});
  }

  TEST_CASE("LLFF") {
    const Set set([](const fs::path& p) { write_llff(p, kFew); });
    const std::string file = "poses_bounds.npy", good = text_of(set.path() / file);
    const auto with = [&](std::size_t row, std::size_t column, double value) {
      std::vector<double> rows = llff_rows(kFew, 4);
      rows[17 * row + column] = value;
      const Bytes bytes = npy_bytes(10, 17, rows);
      return std::string(bytes.begin(), bytes.end());
    };
    set.replace(file, good.substr(0, good.size() - 8),
                {"poses_bounds.npy: the file has not the size that its header says", "1360 bytes of numbers",
                 "1352"});
    set.replace(file, "no table", {"poses_bounds.npy: this is no .npy file"});
    set.refuse(file, "<f8", ">f8", {"the numbers are of a kind that is not read", "'<f8' or '<f4'"});
    set.refuse(file, "False", "True ", {"the table is stored by columns"});
    set.refuse(file, "(10, 17)", "(17, 10)", {"these are no poses and bounds", "17 columns", "got:      10"});
    set.refuse(file, "(10, 17)", "(170,)  ", {"the table has not two axes"});
    set.replace(file, with(2, 16, 0.5), {"row 2: the depth bounds are out of order", "1.5 and 0.5"});
    set.replace(file, with(3, 7, std::nan("")), {"a number is not finite", "in row 3"});
    set.replace(file, with(4, 0, 7), {"row 4: 'transform_matrix'"});
    set.damage(file, 100);
    fs::remove(set.path() / "images_4/frame_0009.png");
    set.expect({"there are not as many pictures as cameras", "10, one per row", "got:      9"});
  }

  TEST_CASE("NR-NeRF") {
    const Set set([](const fs::path& p) { write_nrnerf(p, kFew); });
    const std::string file = "precomputed.json";
    set.refuse(file, "\"bds\"", "\"bounds\"", {"precomputed.json: 'bds' is missing"});
    set.refuse(file, "[1.5, 5], ", "", {"'poses' and 'bds' differ in length", "10 bounds", "got:      9"});
    set.refuse(file, "[1.5, 5]", "[5, 1.5]", {"row 0: the depth bounds are out of order"});
    set.refuse(file, "[1.5, 5]", "[1.5]",
               {"precomputed.json, bounds 0: the array has the wrong shape", "2 elements"});
    set.refuse(file, "[[[", "[[[\"x\", ", {"pose 0: the array has the wrong shape", "5 elements"});
    set.damage(file, 100);
    fs::remove_all(set.path() / "images");
    set.expect({"there are no pictures for these cameras"});
  }
}

}  // namespace
