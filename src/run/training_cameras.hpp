// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/run/cameras.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::run {

/// How the training cameras stand.
enum class Stand {
  around,  ///< all round the box: an orbit is near them everywhere
  film,    ///< one camera on its way, picture after picture
  few,     ///< at no more than kFewPlaces places
  many,    ///< at more places, in no order
  one      ///< at one place
};
inline constexpr std::size_t kFewPlaces = 24;

struct TrainingCameras {
  Stand stand = Stand::one;
  std::string why;         ///< what was measured, a clause
  std::vector<Shot> film;  ///< pictures of one camera on its way, in the order of time; empty: there is none
  std::vector<Shot> places;  ///< every place once, in the split's order; not empty
  Vec3d middle;              ///< of what they look at, scene units: in front of nearly all of them
};

/// Measures how the cameras of a train split stand.
///
/// | stand | if |
/// | --- | --- |
/// | around | from the middle of the box, no direction of the orbit is over 60 degrees from a camera |
/// | one | all places are one |
/// | film | neighbours in time are half as far apart as any two, or nearer, in 8 pictures or more |
/// | few, many | the number of places says so |
///
/// Of the first only those cameras count that stand outside the box and look towards its middle. They must
/// not be on one side, where the mean of their directions is longer than 0.9. The distance of two cameras is
/// the angle between them plus that of their positions as the middle sees it.
/// @param elevation  of the orbit, degrees @pre train has a frame
TrainingCameras survey(const Dataset& data, const Box& box, double elevation);

/// The same of a run. Reads the cameras of its data set, not the pictures. Throws Error (input).
/// @param data  another place of the data set; empty: the run's own
TrainingCameras training_cameras(const Run& run, const std::string& data, double elevation);

/// The shot whose camera is next to the mean of all positions. @pre not empty
const Shot& central(const std::vector<Shot>& shots);

/// Radians, 0 to pi.
double angle_between(const Vec3d& a, const Vec3d& b);

}  // namespace splinevox::run
