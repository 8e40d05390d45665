// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/layouts/read_scene.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// Reads the tracks of points that the data names, or DatasetRules::tracks, and gives each frame of the train
/// split those that it shows: a file (read_track_table), or a folder of optical flow (follow_flow). Its
/// pictures are those of the split in the order of time, or all of the scene. Of pictures that are held out
/// nothing is taken. Adds a note that says how it is understood.
///
/// Throws Error (Fault::input) for a file that is not there, of another shape, or of other pictures, and
/// where two pictures are of one moment: tracks are of one camera.
/// @param sizes  of the pictures of the train split, after turning. @param frames  of the same, after the
/// downscale
/// @return none: there are no tracks
std::optional<DatasetTracks> read_tracks(const std::filesystem::path& folder, const OpenScene& open,
                                         const LoadOptions& options, const std::vector<PictureSize>& sizes,
                                         std::vector<Frame>& frames, std::vector<std::string>& notes);

}  // namespace splinevox::data
