// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"
#include "splinevox/core/depth_map.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// The depth maps of one split's frames, found but not read.
struct DepthPlan {
  DepthKind kind = DepthKind::metric;
  bool used = true;                          ///< false: DatasetRules::depth is "none"
  bool asked = true;                         ///< the rule says what they are; else the data does, or nothing
  std::vector<std::filesystem::path> files;  ///< of each frame, empty where there is none
  std::vector<std::string> where;            ///< how errors name each
  std::vector<std::optional<double>> units;  ///< of each, scene units of one of its numbers
  std::vector<PictureSize> sizes;            ///< of the pictures, after turning
  int downscale = 1;
  std::size_t found = 0, absent = 0;
  std::string first, first_absent;  ///< as the data names them
};

/// Looks for the depth maps that frames name. What they are is the same for all of a split. Throws Error
/// (Fault::input) for a rule that there is not.
/// @param sizes  of the pictures once they are turned
DepthPlan plan_depth(const std::filesystem::path& folder, const RawSplit& split, const DatasetRules& rules,
                     const std::vector<PictureSize>& sizes, int downscale);

/// One map, as large as the picture after the downscale, or smaller. A file is 16-bit grey PNG (a number is a
/// thousandth of a scene unit, unless the data says another), OpenEXR with a channel Z, depth or Y or no
/// other, or .npy or .npz with a table of floats. Of a larger one the nearest number is taken. Throws Error
/// (Fault::input) for another file, for one of another shape than its picture, and for metric depth below 0.
/// @pre the frame has one
DepthMap read_depth(const DepthPlan& plan, std::size_t i);

/// Reads all maps; of several bad ones the first frame's error comes out. @param most  that are read, evenly
/// chosen
std::vector<DepthMap> read_depths(const DepthPlan& plan, std::size_t most = std::size_t(-1));

/// Bytes that the maps take.
double memory_for(const DepthPlan& plan);

/// What there is, with a note that says how it is understood. None: no frame names a map.
/// @param maps  that were read
std::optional<DatasetDepth> note_depth(const DepthPlan& plan, const std::vector<DepthMap>& maps,
                                       std::vector<std::string>& notes);

}  // namespace splinevox::data
