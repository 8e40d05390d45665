// SPDX-License-Identifier: Apache-2.0
// Writes what the Blender acceptance test compares: sequences, FOLDER/camera.json, our own pictures (*.f32:
// rgb over white, then alpha; float32, rows from the top), and mattes.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "run/cryptomatte.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/blob_model.hpp"
#include "support/blob_parts.hpp"

using namespace splinevox;

namespace {

constexpr int kFrames = 5, kShown = 3;
constexpr int kMoments = 32;      ///< of our own motion blur
constexpr double kShutter = 0.5;  ///< Blender's default too

Camera camera() {
  Camera c;
  c.width = 240;
  c.height = 180;
  c.fx = c.fy = 310;
  c.cx = 113;
  c.cy = 95;  // not the middle: the script must shift the lens
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
    out << "[" << c.axes[0][r] << ", " << c.axes[1][r] << ", " << c.axes[2][r] << ", " << c.position[r]
        << "], ";
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

Rendered picture_of(const VoxelModel& model, double time) {
  return render_image(model, camera(), time, {.stop = 1e-4f, .step_scale = 0.25f});
}

Vec3d pixel_of(const Camera& c, const Vec3d& x) {
  const Vec3d d = x - c.position;
  const double depth = -dot(d, c.axes[2]);
  return {c.cx + c.fx * dot(d, c.axes[0]) / depth, c.cy - c.fy * dot(d, c.axes[1]) / depth, depth};
}

/// One sequence, and its clusters, which have to look the same.
void write_still(const std::string& folder) {
  // Band 0 only: Cycles gets the mean over the sphere, which is then the value in every direction.
  const VoxelModel model = test::blob_model(
      96, {.points = 4, .shift = {-0.5f, 0.1f, 0.2f}, .twist = 0.6f, .rigidity = true, .light = 0.8f}, 0);
  ExportOptions options;
  options.last = kFrames;
  const ExportResult result = export_vdb(model, folder + "/export", options);
  write_picture(folder + "/ours.f32", picture_of(model, result.frames[kShown - 1].time));
  options.clusters = 2;
  export_vdb(model, folder + "/clusters", options);
}

/// Colours that change with the view, with the harmonics and with their mean.
void write_view(const std::string& folder) {
  VoxelModel model = test::blob_model(64, {.moves = false}, 3);
  for (std::size_t r = kBrickRows; r < model.radiance.raw.topology->rows(); ++r)
    for (int j = 0; j < model.radiance.sh_count(); ++j) model.radiance.raw.row(r)[4 + j] *= 8;
  ExportOptions options;
  options.last = 1;
  export_vdb(model, folder + "/mean", options);
  options.sh = true;
  export_vdb(model, folder + "/sh", options);
  write_picture(folder + "/view.f32", picture_of(model, 0));
}

/// A known velocity and a mesh that it carries: the picture at the middle of three frames, and the mean over
/// the time that the shutter is open.
void write_blur(const std::string& folder) {
  const Vec3 shift{-0.4f, -0.3f, 0.1f};
  const VoxelModel model = test::blob_model(64, {.shift = shift}, 0);
  ExportOptions options;
  options.last = 3;
  options.mesh = true;
  options.mesh_format = "glb";
  const ExportResult result = export_vdb(model, folder + "/blur", options);
  const double middle = result.frames[1].time,
               open = 0.5 * kShutter;  // of model time: two frames are all of it
  write_picture(folder + "/sharp.f32", picture_of(model, middle));
  Rendered mean = picture_of(model, middle + open * (0.5 / kMoments - 0.5));
  for (int i = 1; i < kMoments; ++i) {
    const Rendered r = picture_of(model, middle + open * ((i + 0.5) / kMoments - 0.5));
    for (std::size_t k = 0; k < r.rgb.data.size(); ++k) mean.rgb.data[k] += r.rgb.data[k];
    for (std::size_t k = 0; k < r.alpha.data.size(); ++k) mean.alpha.data[k] += r.alpha.data[k];
  }
  for (float& v : mean.rgb.data) v /= kMoments;
  for (float& v : mean.alpha.data) v /= kMoments;
  write_picture(folder + "/blurred.f32", mean);
  const Vec3d centre = Vec3d{0.1, -0.05, 0} - 0.5 * cast<double>(shift);
  const Vec3d half = -0.5 * open * cast<double>(shift);
  const Vec3d a = pixel_of(camera(), centre - half), b = pixel_of(camera(), centre + half);
  std::ofstream(folder + "/blur.json") << "[" << b.x - a.x << ", " << b.y - a.y << "]\n";
}

/// Four parts as Cryptomatte, and how much of every pixel each of them is.
void write_mattes(const std::string& folder) {
  const VoxelModel model = test::blob_model(24, {}, 1, 6);
  run::PartMattes mattes(model, test::quarters(model), Device::cpu);
  const Image alpha = render_image(model, camera(), 0.5).alpha;
  ExrNotes notes;
  notes.texts = mattes.attributes();
  write_exr(folder + "/mattes.exr", mattes.layers(camera(), 0.5, alpha), notes);
  std::ofstream out(folder + "/mattes.f32", std::ios::binary);
  for (const Image& part : mattes.coverage(camera(), 0.5, alpha))
    out.write(reinterpret_cast<const char*>(part.data.data()),
              std::streamsize(part.data.size() * sizeof(float)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  std::filesystem::create_directories(folder);
  write_camera(folder + "/camera.json", camera());
  write_still(folder);
  write_view(folder);
  write_blur(folder);
  write_mattes(folder);
  return 0;
}
