// SPDX-License-Identifier: Apache-2.0
// The Gibson rooms of NeRFlow: as D-NeRF's files, but the angle is in degrees, the matrices are world to
// camera and times are step numbers.
#include <cmath>
#include <numbers>

#include "data/json_file.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path file_of(const fs::path& folder, const std::string& split) {
  return folder / ("transform_" + split + ".json");
}

double radians(double angle, const std::string& where) {
  if (angle > std::numbers::pi && angle < 180) return angle * std::numbers::pi / 180;
  fail(
      {where, "'camera_angle_x' is no field of view in degrees, as transform_*.json of NeRFlow has it",
       "above 3.15 and below 180", number(angle),
       angle > 0 && angle <= std::numbers::pi
           ? "it looks like radians: if the matrices are camera to world, name the file transforms_train.json"
           : ""});
}

RawSplit read_split(const fs::path& folder, const std::string& name) {
  const fs::path path = file_of(folder, name);
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  RawSplit split = read_frames(file, where, "timestep");
  split.name = name;
  for (std::size_t i = 0; i < split.frames.size(); ++i) {
    RawFrame& frame = split.frames[i];
    frame.label = "frame " + std::to_string(i);
    for (auto& angle : {&frame.lens.camera_angle_x, &frame.lens.camera_angle_y})
      if (*angle) *angle = radians(**angle, where);
    const RigidPose seen = frame.pose;  // of the world, from the camera
    std::array<Vec3d, 3> axes;
    for (int a = 0; a < 3; ++a) axes[std::size_t(a)] = {seen.axes[0][a], seen.axes[1][a], seen.axes[2][a]};
    const Vec3d& t = seen.position;
    frame.pose.axes = axes;
    frame.pose.position = -(t.x * axes[0] + t.y * axes[1] + t.z * axes[2]);
    frame.matrix = matrix_of(axes, frame.pose.position);
  }
  read_times(frames_of(file, where), "timestep", split);
  return split;
}

}  // namespace

bool is_gibson(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(file_of(folder, "train"), ignored);
}

RawScene read_gibson(const fs::path& folder) {
  RawScene scene;
  for (const char* name : {"train", "val", "test"}) {
    std::error_code ignored;
    if (fs::exists(file_of(folder, name), ignored)) scene.splits.push_back(read_split(folder, name));
  }
  scene.one_list = scene.splits.size() == 1;
  scene.notes.push_back("camera_angle_x was taken as degrees, transform_matrix as world to camera (NeRFlow)");
  return scene;
}

}  // namespace splinevox::data
