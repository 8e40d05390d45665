// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// A picture in memory and what is known of it.
struct PosedPicture {
  std::string name;                          ///< that no other has
  Picture image;                             ///< with its pixels
  std::array<double, 16> camera_to_world{};  ///< row-major, scene units; OpenGL axes
  double fx = 0, fy = 0, cx = 0, cy = 0;     ///< pixels
  double time = 0;                           ///< any unit, as Dataset::time_map makes of it
  std::string camera = {};                   ///< that took it; empty: pose and lens tell
  PixelMask ignored = {};                    ///< as Frame::ignored
};

/// Pictures of one split, in order.
struct PosedSplit {
  std::string name;  ///< "train", "val" or "test"; empty: all there are, to be divided as load_dataset does
  std::vector<PosedPicture> pictures;
};

/// A data set of pictures in memory, checked as load_dataset checks one on disk: with the same times, cameras
/// and held-out pictures. @param name  what messages and Dataset::path call it. Throws Error (Fault::input)
/// naming the picture.
Dataset dataset_of(std::vector<PosedSplit> splits, const std::string& name, std::optional<Box> box = {});

}  // namespace splinevox
