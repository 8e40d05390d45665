// SPDX-License-Identifier: Apache-2.0
#include "data/rig_layouts.hpp"
#include "data/spoil.hpp"

/// What the readers of rigs say of broken input; docs/data.md has these as a table.
namespace {

using namespace splinevox;
using namespace splinevox::test;

const Cameras kRig = rig_cameras(4);

TEST_SUITE("data/bad rigs") {
  TEST_CASE("Dynamic 3D Gaussians") {
    const Set set([](const fs::path& p) { write_gaussians(p, kRig, 3); });
    const std::string file = "train_meta.json";
    set.refuse(file, "\"w\": 12", "\"w\": \"12\"", {"train_meta.json: 'w' is not a number"});
    set.refuse(file, "\"w\": 12", "\"w\": 24", {"moment 0, camera 0: 'w' is not the picture's size"});
    set.refuse(file, "\"h\": 8,", "", {"train_meta.json: 'h' is missing"});
    set.refuse(file, "\"k\"", "\"K\"", {"train_meta.json: 'k' is missing"});
    set.refuse(file, "\"fn\": [[", "\"fn\": [3, [", {"'fn' is no table", "a moment that is 3"});
    set.refuse(file, "\"fn\": [[", "\"fn\": [[\"a.png\"], [", {"have different numbers of moments"});
    set.refuse(
        file, "\"cam_id\": [[0, 1]", "\"cam_id\": [[0]",
        {"'cam_id' and 'fn' have different numbers of cameras at moment 0", "expected: 2", "got:      1"});
    set.refuse(file, "\"cam_id\": [[0, 1]", "\"cam_id\": [[0, 0]",
               {"moment 0, camera 1: 'cam_id' is there twice at this moment", "'0'"});
    set.refuse(file, "\"cam_id\": [[0, 1]", "\"cam_id\": [[0, 1.5]", {"'cam_id' is no name of a camera"});
    set.refuse(file, "\"cam_id\": [[0, 1]", "\"cam_id\": [[0, 2]",
               {"test_meta.json: a camera of the test split is one of the train split", "'2' of moment 0"});
    set.refuse(file, "\"0/0000.png\"", "\"0/0900.png\"",
               {"moment 0, camera 0: the image is missing", "'ims/0/0900.png'"});
    set.refuse(file, "\"0/0000.png\"", "\"../../a.png\"", {"leads out of the data set's folder"});
    set.refuse(file, "\"0/0000.png\"", "7", {"moment 0, camera 0: 'fn' is not a path"});
    set.refuse(file, "[0, 0, 1]]", "[0, 0, 1, 4]]", {"'k' has a row of the wrong shape", "an array of 4"});
    set.refuse(file, "[0, 0, 1]]", "[0, 0, \"1\"]]", {"'k' holds something else than numbers"});
    set.refuse(file, "[0, 0, 1]]", "[0, 0, 2]]", {"'k' is no matrix of a lens"});
    set.refuse(file, "[[11, 0, 6]", "[[11, 0.5, 6]", {"'k' has skew"});
    set.refuse(file, "[[11, 0, 6]", "[[0, 0, 6]", {"moment 0, camera 0"});
    set.refuse(file, "[0, 0, 0, 1]]", "[0, 0, 1, 1]]", {"'w2c' does not end in 0 0 0 1"});
    set.refuse(file, "[0, 0, 0, 1]]", "[0, 0, 0, 1], [0, 0, 0, 1]]", {"'w2c' has the wrong shape"});
    set.refuse(file, "\"w2c\": [[[[", "\"w2c\": [[[[1e300, 0, 0, 0], [", {"'w2c' has the wrong shape"});
    const std::string good = text_of(set.path() / file);
    const std::size_t first = good.find("[[[[", good.find("w2c")) + 4;
    set.replace(file, std::string(good).replace(first, good.find(',', first) - first, "1e300"),
                {"moment 0, camera 0", "1e+300"});
    set.replace(file, "[]", {"train_meta.json: this is no object with fields"});
    set.damage(file, 150);
    set.damage("test_meta.json", 60);
  }

  TEST_CASE("PINF") {
    if (!has_ffmpeg()) return;
    const Set set([](const fs::path& p) { write_pinf(p, kRig); });
    const std::string file = "info.json";
    set.refuse(file, "train01.mp4", "train09.mp4",
               {"'train_videos' 1: the film is missing", "'train09.mp4'"});
    set.refuse(file, "train01.mp4", "../train01.mp4",
               {"'train_videos' 1", "leads out of the data set's folder"});
    set.refuse(file, "\"file_name\"", "\"file\"", {"'train_videos' 0: 'file_name' is missing"});
    set.refuse(file, "\"train01.mp4\"", "1", {"'train_videos' 1: 'file_name' is not a path"});
    set.refuse(file, "\"frame_rate\": 5", "\"frame_rate\": 6",
               {"'train_videos' 1: films have different frame rates", "6, as the first"});
    set.refuse(file, "\"frame_num\": 4", "\"frame_num\": 6",
               {"the film has fewer frames than 'frame_num' says", "expected: 6", "got:      5"});
    set.refuse(file, "\"frame_num\": 4", "\"frame_num\": 0", {"'frame_num' is no number of frames"});
    set.refuse(file, "\"frame_num\": 4, ", "", {"'train_videos' 0: 'frame_num' is missing"});
    set.refuse(file, "\"camera_angle_x\"", "\"angle\"", {"'train_videos' 0: 'camera_angle_x' is missing"});
    set.refuse(file, "\"camera_angle_x\": ", "\"camera_angle_x\": 9", {"film train00.mp4"});
    set.refuse(file, "[80, 120]", "[120, 80]", {"film train00.mp4"});
    set.refuse(file, "[80, 120]", "[80]", {"'train_videos' 0: 'camera_hw' is no size"});
    set.refuse(file, "\"transform_matrix\": [[", "\"transform_matrix\": [[1, 2], [",
               {"'train_videos' 0: 'transform_matrix' has the wrong shape"});
    set.refuse(file, "\"transform_matrix\"", "\"matrix\"",
               {"'train_videos' 0: 'transform_matrix' is missing"});
    set.refuse(file, "\"transform_matrix_list\": [", "\"transform_matrix_list\": 4, \"x\": [",
               {"'test_videos' 0: 'transform_matrix_list' is too short", "4 matrices"});
    set.refuse(file, "\"test_videos\": [", "\"test_videos\": [], \"x\": [",
               {"'test_videos' is no list of films"});
    set.refuse(file, "\"voxel_scale\": [1, 2, 4]", "\"voxel_scale\": [1, 2]", {"'voxel_scale' is no size"});
    set.refuse(file, "\"voxel_scale\": [1, 2, 4]", "\"voxel_scale\": -1", {"'voxel_scale' is no size"});
    set.refuse(file, "\"voxel_scale\"", "\"scale\"", {"'voxel_scale' is missing"});
    set.refuse(file, "[-1, 0, 0, 0.25]", "[0, 0, 0, 0.25]", {"'voxel_matrix' gives no volume"});
    set.refuse(file, "[-1, 0, 0, 0.25], ", "", {"'voxel_matrix' has the wrong shape"});
    set.refuse(file, "\"near\": 1.1", "\"near\": ", {"malformed JSON"});
    write_bytes(set.path() / "train02.mp4", {1, 2, 3});
    set.expect({"train02.mp4: this is no film that ffprobe can read"});
    set.replace(file, "{\"name\": 1}", {"no known kind of data set", "info.json with train_videos (PINF)"});
  }

  TEST_CASE("EasyMocap: the calibration") {
    const Set set([](const fs::path& p) { write_easymocap(p, kRig, 3); });
    const std::string in = "intri.yml", ex = "extri.yml";
    set.refuse(in, "- \"03\"\n", "- \"03\"\n  - \"07\"\n", {"a camera has a lens and no pose", "'07'"});
    set.refuse(ex, "- \"03\"\n", "- \"03\"\n  - \"07\"\n", {"a camera has a pose and no lens", "'07'"});
    set.refuse(in, "- \"03\"", "- \"02\"", {"'names' has a camera twice", "'02'"});
    set.refuse(in, "- \"03\"", "- \"../03\"", {"'names' holds what is no name of a folder"});
    set.refuse(in, "names:", "name:", {"intri.yml: 'names' is missing"});
    set.refuse(in, "K_01", "k_01", {"intri.yml: 'K_01' is missing"});
    set.refuse(ex, "T_02", "t_02", {"extri.yml: 'T_02' is missing"});
    set.refuse(ex, "R_02", "r_02", {"extri.yml: 'R_02' is missing"});
    set.refuse(ex, "R_01: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ ",
               "R_01: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 1",
               {"'Rot_01' and 'R_01' are different rotations"});
    set.refuse(in, "data: [ 11", "data: [ .Nan", {"line 8: 'K_00' holds a number that is not finite", "nan"});
    set.refuse(in, "data: [ 11", "data: [ -.Inf", {"'K_00' holds a number that is not finite", "-inf"});
    set.refuse(in, "data: [ 11, 0, 5.5", "data: [ 11, 1, 5.5",
               {"'K_00' is no matrix of a lens without skew"});
    set.refuse(in, "data: [ 11", "data: [ eleven",
               {"line 8: a matrix holds something else than numbers", "'eleven'"});
    set.refuse(in, "data: [ 11,", "data: [ 11", {"line 8: a matrix holds something else than numbers"});
    set.refuse(in, "rows: 3", "rows: 2", {"line 8: a matrix has not as many numbers", "expected: 2 x 3"});
    set.refuse(in, "rows: 3", "rows: -3", {"line 9: 'rows' of a matrix is no number of them"});
    set.refuse(in, "rows: 5\n   cols: 1", "rows: 1\n   cols: 5\n   cols: 1",
               {"a matrix has not as many numbers"});
    set.refuse(in, "K_01: ", "K_00: ", {"the key 'K_00' is there twice"});
    set.refuse(in, "K_01: ", "names: [\"00\"]\nK_01: ", {"the key 'names' is there twice"});
    set.refuse(in, "K_01: !!opencv-matrix", "K_01: !!opencv-nd-matrix", {"this is no plain value"});
    set.refuse(in, "K_01: !!opencv-matrix", "K_01: &a\n", {"intri.yml, line"});
    set.refuse(in, "K_01: !!opencv-matrix", "H_00: 8\nW_00: none\nK_01: !!opencv-matrix",
               {"the size of camera '00' is no size", "'none'"});
    set.refuse(in, "K_01: !!opencv-matrix", "H_00: 8\nW_00: 8\nK_01: !!opencv-matrix", {"picture images/00"});
    set.refuse(in, "%YAML:1.0\n", "%YAML:1.0\nnonsense\n",
               {"line 2: this is no key with a value", "'nonsense'"});
    set.refuse(ex, "T_03: ", "T_03: [1, 2,\nT_04: ", {"extri.yml, line"});
    set.damage(in, 150);
    set.damage(ex, 150);
    fs::remove(set.path() / in);
    set.expect({"intri.yml: the file does not exist"});
  }

  TEST_CASE("EasyMocap: the pictures") {
    const Set set([](const fs::path& p) { write_easymocap(p, kRig, 5); });
    const fs::path images = set.path() / "images";
    fs::remove(images / "02/000003.png");
    set.expect({"picture images/02/000003.png: the image is missing"});
    CHECK(load_dataset(set.path().string()).notes[0].find("1 of 20 pictures are missing and left out") == 0);
    write_png(images / "02/000003.png", rig_picture(2, 3));
    fs::rename(images / "03", images / "09");
    set.expect({"extri.yml: there are no pictures of camera '03'", "10 of 25 frames are like this"});
    fs::copy(images / "01", images / "03", fs::copy_options::recursive);
    set.expect({"there are pictures of '09' and no camera", "'00', '01', '02', '03'"});
    fs::remove_all(images);
    set.expect({"extri.yml: there are no pictures of these cameras", "images/NAME/000000.jpg"});
  }

  TEST_CASE("a still model: cameras and folders that miss each other") {
    const Set set([](const fs::path& p) {
      write_still_model(p, kRig);
      write_camera_folders(p, 4, 5);
    });
    fs::rename(set.path() / "cam03", set.path() / "cam12");
    set.expect(
        {"transforms.json: there are no pictures of camera 'cam03'", "--missing skip to go on without 10"});
    const Dataset rest = load_dataset(set.path().string(), {.rules = {.missing = "skip"}});
    CHECK(rest.cameras.size() == 3);
    write_camera_folders(set.path(), 4, 5);
    set.expect({"transforms.json: there are pictures of 'cam12' and no camera", "a pose for every camera"});
    fs::remove_all(set.path() / "cam12");
    for (int c = 0; c < 4; ++c)  // names that no two folders share
      for (int k = 0; k < 5; ++k)
        fs::rename(set.path() / numbered("cam", c) / (padded(k) + ".png"),
                   set.path() / numbered("cam", c) / (numbered("c", c) + "_" + padded(k) + ".png"));
    CHECK(load_dataset(set.path().string()).cameras.size() == 4);
    fs::remove(set.path() / "cam02/c02_0004.png");
    set.expect({"cameras have different numbers of pictures", "5, as 'cam03' has", "4 of 'cam02'"});
  }
}

}  // namespace
