// SPDX-License-Identifier: Apache-2.0
// Writes what the Blender acceptance test compares: FOLDER/export (a sequence), FOLDER/camera.json, and
// FOLDER/ours.f32, our own picture of frame 3 (rgb over white, then alpha; float32, rows from the top).
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "support/blob_model.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/render/render_image.hpp"

using namespace splinevox;

namespace {

constexpr int kFrames = 5, kShown = 3;

Camera camera() {
  Camera c;
  c.width = 240, c.height = 180;
  c.fx = c.fy = 310;
  c.cx = 113, c.cy = 95;  // not the middle: the script must shift the lens
  c.position = {1.9, -2.2, 1.3};
  c.axes[2] = normalize(c.position - Vec3d{0.15, 0, -0.05});
  c.axes[0] = normalize(cross(Vec3d{0, 0, 1}, c.axes[2]));
  c.axes[1] = cross(c.axes[2], c.axes[0]);
  return c;
}

void write_camera(const std::string& path, const Camera& c) {
  std::ofstream out(path);
  out.precision(17);
  out << "{\"w\": " << c.width << ", \"h\": " << c.height << ", \"fl_x\": " << c.fx << ", \"fl_y\": " << c.fy
      << ", \"cx\": " << c.cx << ", \"cy\": " << c.cy << ",\n \"transform_matrix\": [";
  for (int r = 0; r < 3; ++r)
    out << "[" << c.axes[0][r] << ", " << c.axes[1][r] << ", " << c.axes[2][r] << ", " << c.position[r] << "], ";
  out << "[0, 0, 0, 1]]}\n";
}

void write_picture(const std::string& path, const Rendered& picture) {
  std::ofstream out(path, std::ios::binary);
  for (int y = 0; y < picture.rgb.height; ++y)
    for (int x = 0; x < picture.rgb.width; ++x) {
      out.write(reinterpret_cast<const char*>(picture.rgb.pixel(x, y)), 12);
      out.write(reinterpret_cast<const char*>(picture.alpha.pixel(x, y)), 4);
    }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  std::filesystem::create_directories(folder);
  // Band 0 only: Cycles gets the mean over the sphere, which is then the value in every direction.
  const VoxelModel model =
      test::blob_model(96, {.points = 4, .shift = {-0.5f, 0.1f, 0.2f}, .twist = 0.6f, .rigidity = true, .light = 0.8f}, 0);
  ExportOptions options;
  options.last = kFrames;
  const ExportResult result = export_vdb(model, folder + "/export", options);
  write_camera(folder + "/camera.json", camera());
  const Rendered ours =
      render_image(model, camera(), result.frames[kShown - 1].time, {.stop = 1e-4f, .step_scale = 0.25f});
  write_picture(folder + "/ours.f32", ours);
  std::printf("%d frames, frame %d at model time %g\n", kFrames, kShown, result.frames[kShown - 1].time);
  return 0;
}
