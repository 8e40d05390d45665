// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/tracks/flow_file.hpp"
#include "data/tracks/followed.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

/// Follows points through a film by the optical flow between its pictures.
/// Every square of a grid that no point is in gets one at its centre. A point is lost where flow is not known
/// or leads outside, where flow backward does not lead back (Sundaram, Brox and Keutzer 2010, eq. 5), where
/// an older one comes as near as a quarter of a square, and after kLongest pictures, since errors add up.
/// A few files are in memory at a time. Throws Error (Fault::input) as read_flow, for flow of another shape
/// than the pictures or not all of one size, and for a number of files that is none of `counts` less 1.
/// @param files  that find_flow found in the folder
/// @param counts  of pictures that it may be of, those that train first. @param size  of the pictures
FollowedPoints follow_flow(const std::filesystem::path& folder, const FlowFiles& files,
                           const std::string& where, const std::vector<std::size_t>& counts,
                           const PictureSize& size, std::vector<std::string>& notes);

}  // namespace splinevox::data
