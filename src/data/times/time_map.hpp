// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "data/layouts/transforms.hpp"
#include "splinevox/core/camera.hpp"

namespace splinevox::data {

/// The map a train split's raw times call for: the identity if they lie in [0, 1] already and fill a quarter
/// of it or more (the convention of D-NeRF), else their range onto [0, 1]. A range below 1e-9 gives scale 0:
/// nothing moves. (numerics H6)
/// @param part  they are a part of the data's times: their range is mapped in any case
TimeMap fit_time_map(const std::vector<double>& raw, bool part = false);

/// The map of a data set, from its train split.
/// @param train   null if the folder has none: then the identity, and the splits' times must lie in [0, 1].
/// @param splits  those that were read, for that check. @param part  as fit_time_map. Throws Error
/// (Fault::input).
TimeMap choose_time_map(const RawSplit* train, const std::vector<RawSplit>& splits,
                        std::vector<std::string>& notes, bool part = false);

/// A frame's time in the model's [0, 1].
inline double model_time(const RawSplit& split, std::size_t frame, const TimeMap& map) {
  return map.scale == 0 ? 0 : map(split.frames[frame].time);
}

/// One line for each thing about a split's times that a user may want to know.
void note_times(const RawSplit& split, const TimeMap& map, std::vector<std::string>& notes);

}  // namespace splinevox::data
