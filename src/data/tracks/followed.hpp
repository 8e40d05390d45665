// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// What every message about tracks may offer.
inline constexpr const char* kWithoutTracks = "--tracks none trains without tracks";

/// Points that are followed through pictures.
struct FollowedPoints {
  std::size_t points = 0;
  /// Of each picture in the order of time, in pixels of the picture as it is stored, upright.
  std::vector<std::vector<VisiblePoint>> seen;
};

}  // namespace splinevox::data
