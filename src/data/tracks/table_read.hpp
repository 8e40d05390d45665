// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/tracks/followed.hpp"

namespace splinevox::data {

/// Tracks as a .npy file, or a .npz file with an array `tracks`: places in pixels, (points, pictures, 2) or
/// (pictures, points, 2), and in .npz perhaps an array that says which are seen. Throws Error (Fault::input)
/// for another file, for one of another shape, and for one of other pictures.
/// @param counts  of pictures that it may be of, those that train first
FollowedPoints read_track_table(const std::filesystem::path& path, const std::string& where,
                                const std::vector<std::size_t>& counts);

}  // namespace splinevox::data
