// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// One camera of LLFF's tables: 3 rows of [rotation | position | height, width, focal length] and depths.
struct PoseRow {
  std::array<double, 15> pose{};
  std::array<double, 2> near_far{};
};

/// The rows of a folder's poses_bounds.npy. @param where  gets how messages name the file. Throws Error
/// (Fault::input).
std::vector<PoseRow> read_poses_bounds(const std::filesystem::path& folder, std::string& where);

/// A camera, its picture not yet known. @param llff  the rotation's columns point down, right and back; else
/// right, up and back. Throws Error (Fault::input).
RawFrame frame_of_row(const PoseRow& row, bool llff, const std::string& where);

/// Refuses a number of files that is not that of the cameras.
void check_count(std::size_t cameras, std::size_t files, const char* what, const std::string& where);

}  // namespace splinevox::data
