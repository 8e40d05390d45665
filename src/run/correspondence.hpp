// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "data/truth.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox::run {

/// What a figure of no pairs is: no number.
inline constexpr double kNoPairs = std::numeric_limits<double>::quiet_NaN();

/// Median and 90th percentile of distances, scene units.
struct Distances {
  std::size_t count = 0;
  double median = kNoPairs, p90 = kNoPairs;
};

/// How well a model's motion agrees with true surface points.
///
/// A pair is one surface point that is visible at two times: two pixels whose rest positions agree within
/// `kSameRest` of the box.
struct MotionScore {
  double edge = 0;        ///< longest edge of the box, scene units: 100%
  double voxel = 0;       ///< of the radiance lattice, scene units
  Distances canonical;    ///< |x + Delta(x, t) - (y + Delta(y, s))| over pairs (x, t), (y, s): 0 where motion
                          ///< is right
  Distances tracked;      ///< |x carried from t to s - y| over pairs; includes kSameRest
  Distances tracked_far;  ///< those of them whose times are at least kFar apart
  double folded = kNoPairs;  ///< share of tracked points flagged on the way, [0, 1]
  std::size_t still_pairs = 0, moving_pairs = 0;
  /// Share of pairs on static surface whose displacement differs by more than half a voxel.
  double still_moved = kNoPairs;
  /// Share of pairs that truly move by over kTrulyMoves of the box whose displacement differs by less than
  /// half a voxel.
  double moving_missed = kNoPairs;
};

inline constexpr double kSameRest = 0.002;   ///< of the box's longest edge
inline constexpr double kFar = 0.5;          ///< model time
inline constexpr double kTrulyMoves = 0.02;  ///< of the box's longest edge

/// Distance between neighbouring pixels' surface points above which read_truth takes them for two surfaces,
/// share of the box.
inline constexpr double kSilhouette = 0.03;

/// Scores a model against the surface points of several frames. Deterministic: at most `per_frame` points a
/// frame, evenly spread.
MotionScore score_motion(const VoxelModel& model, const std::vector<SurfaceFrame>& frames,
                         std::size_t per_frame = 1000);

}  // namespace splinevox::run
