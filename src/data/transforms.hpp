// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "data/camera_check.hpp"

namespace splinevox::data {

/// One frame of a transforms file: checked, its picture not yet looked for.
struct RawFrame {
  std::string file_path;            ///< as written
  double time = 0;                  ///< the data's own time, or index / (n - 1) where the file has none
  std::array<double, 16> matrix{};  ///< as written, row-major
  RigidPose pose;
  Lens lens;
};

/// One transforms_*.json.
struct RawSplit {
  std::string name;   ///< "train", "val" or "test"
  std::string file;   ///< how messages name the JSON file
  bool timed = true;  ///< false: no frame has a 'time', times are indices
  std::vector<RawFrame> frames;

  /// "lego/transforms_train.json, frame 12"
  std::string where(std::size_t frame) const { return file + ", frame " + std::to_string(frame); }
};

/// The name of a split's file within the folder: "transforms_train.json".
std::string transforms_name(const std::string& split);

/// Reads and checks one split of a NeRF / D-NeRF folder. Throws Error (Fault::input).
/// @param folder  as the user gave it; messages begin with it.
RawSplit read_transforms(const std::filesystem::path& folder, const std::string& split);

/// The picture a frame names: file_path itself, or with .png added. Must lie in the folder, links resolved.
/// @param root  the folder in canonical form. @return an absolute path. Throws Error (Fault::input).
std::filesystem::path locate_image(const std::filesystem::path& root, const std::string& file_path,
                                   const std::string& where);

}  // namespace splinevox::data
