// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "splinevox/field/model.hpp"

namespace splinevox {

/// Where a material point is at a time.
struct TrackedPoint {
  Vec3 position;        ///< scene units
  bool folded = false;  ///< the way there led through a fold, a jump or a place the warp does not reach: do
                        ///< not trust it
};

/// Carries points of one time to other times. A point keeps its canonical place x + Delta(x, t); at every
/// other time it is where the warp looks that place up. The inverse is found by going through time in short
/// steps, each predicted by the material velocity and corrected by invert_warp, so that of several places
/// that look alike the one reached by moving is taken.
/// @param from  model time of the points; times beyond [0, 1] are clamped.
/// @return [times][points]
std::vector<std::vector<TrackedPoint>> track(const VoxelModel& model, std::span<const Vec3> points,
                                             double from, std::span<const double> times);

/// The canonical places x + Delta(x, t) of points of one time; `folded` where the warp there is no longer one
/// to one.
std::vector<TrackedPoint> to_canonical(const VoxelModel& model, std::span<const Vec3> points, double time);

}  // namespace splinevox
