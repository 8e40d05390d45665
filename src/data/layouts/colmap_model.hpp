// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "data/camera_check.hpp"
#include "data/layouts/raw_scene.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox::data {

/// A camera model of COLMAP (its documentation, "Camera Models").
struct ColmapKind {
  const char* name;
  int id;                  ///< in binary files
  bool fisheye;            ///< its coefficients are those of OpenCV's fisheye
  const char* parameters;  ///< what its numbers are, in their order
  int count() const;       ///< how many they are
};
/// Null if there is none of that number or name.
const ColmapKind* find_kind(std::int64_t id);
const ColmapKind* find_kind(const std::string& name);

struct ColmapCamera {
  const ColmapKind* kind = nullptr;
  double width = 0, height = 0;  ///< pixels
  std::vector<double> params;
};
/// The lens of ours that it is. Throws Error (Fault::input) naming the model if it is none.
Lens lens_of(const ColmapCamera& camera, const std::string& where);

struct ColmapImage {
  std::array<double, 4> rotation{};  ///< quaternion w, x, y, z: world to camera
  Vec3d translation{};
  std::int64_t camera = 0;
  std::string name;
};

struct ColmapModel {
  std::string where;  ///< how messages name the file of images
  std::map<std::int64_t, ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<Vec3d> points;  ///< none if there is no file of them
  double observations = 0;    ///< of all points; binary files alone give them here
  double error = 0;           ///< their mean distance from where the model shows the point, pixels
};

/// An image's camera: pose, lens, and its name as file_path. Throws Error (Fault::input).
RawFrame frame_of(const ColmapModel& model, const ColmapImage& image);

/// Read cameras, images and points3D of a folder. Throw Error (Fault::input).
/// @{
ColmapModel read_colmap_text(const std::filesystem::path& folder);
ColmapModel read_colmap_binary(const std::filesystem::path& folder);
/// @}

}  // namespace splinevox::data
