// SPDX-License-Identifier: Apache-2.0
// What a data set is made of: transforms, PNG, OpenEXR.
#include <random>

#include "data/pictures/exr.hpp"
#include "fuzz/seeds.hpp"
#include "fuzz/targets.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/voxel_splats.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

namespace splinevox::fuzz {
namespace {

Image noise(int width, int height, int channels, unsigned seed) {
  Image image(width, height, channels);
  std::mt19937 random(seed);
  for (float& v : image.data) v = float(random() % 256) / 255;
  return image;
}

std::string text_of(const test::Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

int dataset_json(const std::uint8_t* data, std::size_t size) {
  static std::string ready;  // of which process the pictures are
  if (ready != folder()) {
    for (const char* name : {"/train/r_0.png", "/train/r_1.png", "/train/r_2.png"})
      test::write_png(folder() + name, test::flat_png(2, 2));
    ready = folder();
  }
  put("transforms_train.json", data, size);
  return verdict([] { load_dataset(folder(), {.splits = {"train"}, .time_map = {}}); });
}

std::vector<std::string> dataset_seeds() {
  std::vector<std::string> timed, plain;
  for (int i = 0; i < 3; ++i) {
    const std::string matrix = test::matrix_text(test::orbit_matrix(0.7 * i)),
                      file = "./train/r_" + std::to_string(i);
    timed.push_back(test::frame_text(file, "0." + std::to_string(5 * i), matrix));
    plain.push_back(test::frame_text(file + ".png", "", matrix));
  }
  return {
      test::transforms_text(timed),
      test::transforms_text(plain,
                            "\"fl_x\": 3.5, \"fl_y\": 3.25, \"cx\": 1, \"cy\": 1, \"w\": 2, \"h\": 2,"),
      test::transforms_text(
          timed,
          "\"camera_angle_x\": 0.8, \"camera_angle_y\": 0.7, \"k1\": 0, \"aabb\": [[0, 1], {\"a\": null}],")};
}

int png(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("picture.png", data, size);
  return verdict([&] { read_png(path); });
}

std::vector<std::string> png_seeds() {
  std::vector<std::string> out;
  for (const int channels : {1, 3, 4}) {
    const std::vector<char> bytes = encode_png(noise(13, 9, channels, unsigned(channels)));
    out.emplace_back(bytes.begin(), bytes.end());
  }
  out.push_back(text_of(test::png_bytes(test::flat_png(5, 4))));
  test::TinyPng palette{4, 2, 2, test::PngKind::palette, {0x1b, 0xe4}};
  palette.palette = {1, 2, 3, 40, 50, 60, 7, 8, 9, 100, 110, 120};
  palette.trns = {0, 128};
  out.push_back(text_of(test::png_bytes(palette)));
  return out;
}

void mend_png(std::string& file) {
  const auto be32 = [&](std::size_t at) {
    std::uint32_t v = 0;
    for (std::size_t i = 0; i < 4; ++i) v = v << 8 | std::uint8_t(file[at + i]);
    return v;
  };
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t size = be32(at);
    if (size > file.size() - at - 12) return;
    const std::uint32_t crc =
        test::crc32(reinterpret_cast<const std::uint8_t*>(file.data()) + at + 4, size + 4);
    for (std::size_t i = 0; i < 4; ++i) file[at + 8 + size + i] = char(crc >> (24 - 8 * i));
    at += 12 + size;
  }
}

int exr(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("picture.exr", data, size);
  return verdict([&] { read_exr_layers(path); });
}

std::vector<std::string> exr_seeds() {
  return {made_by([](const std::string& p) {
            write_exr(p, {{"", noise(11, 7, 4, 1), {}}});
          }),
          made_by([](const std::string& p) {
            write_exr(p, {{"position", noise(9, 9, 3, 2), {"X", "Y", "Z"}},
                          {"rest", noise(9, 9, 3, 3), {}},
                          {"depth", noise(9, 9, 1, 4), {}}});
          })};
}

int splat_ply(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("splats.ply", data, size);
  return verdict([&] {
    const SplatFile file(path);
    Splat splat;
    for (std::size_t i = 0; i < file.size(); ++i) file.read(i, splat);
  });
}

std::vector<std::string> splat_seeds() {
  std::vector<std::string> seeds;
  for (const int degree : {0, 1}) {
    VoxelSplats splats;
    splats.size = 0.1;
    splats.degree = degree;
    splats.places = {{0, 1, 2}, {3, 4, 5}};
    splats.opacities = {0.25f, 0.75f};
    splats.harmonics.resize(std::size_t(2 * 3 * splats.count()), 0.5f);
    seeds.push_back(splat_ply(splats));
  }
  std::string text = "ply\nformat ascii 1.0\nelement vertex 1\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                           "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    text += std::string("property float ") + name + "\n";
  seeds.push_back(text + "end_header\n0 0 0 1 1 1 0.5 -2 -2 -2 1 0 0 0\n");
  return seeds;
}

}  // namespace splinevox::fuzz
