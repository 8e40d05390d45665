// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// The model at one time, contracted: per motion vertex one displacement and one raw rigidity instead of K
/// control points. Build once per frame, then sample anywhere. Plain slow-path sampling in float for export,
/// tracking and tests; the renderer has its own packed path with the same formulas.
///
/// The model must outlive it. Copies share what was contracted; const use from several threads is safe.
class FrameSampler {
 public:
  FrameSampler(const VoxelModel& model, double time);
  /// The model at a parameter of its curves, whatever its time curve makes of time; velocities per unit of
  /// the parameter.
  struct AtParameter {
    double value;  ///< in [0, 1]
  };
  FrameSampler(const VoxelModel& model, AtParameter parameter);

  struct Warp {
    Vec3 displacement;           ///< Delta(x, t) = x' - x, scene units
    Vec3 velocity_to_canonical;  ///< dDelta/dt, scene units per unit of model time
    Vec3 gradient[3];            ///< gradient[i][j] = d Delta_i / d x_j, unitless
    float rigidity;              ///< r in [0, 1]
    float light = 1;             ///< gain of the colour at this place and time, in (0, 2)
    float presence = 0;          ///< what is added to the raw density at this place and time
  };
  Warp warp(Vec3 x) const;
  Vec3 canonical(Vec3 x) const;  ///< x + Delta(x, t)

  struct Radiance {
    float density;  ///< 1 / scene unit
    Vec3 color;     ///< sigmoid(rgb), before the view rescale, in [0, 1]
    float sh[16];   ///< coefficients of the view rescale (sh_count() of them)
  };
  /// At a canonical position; outside the box or in an absent brick the density is 0.
  /// @param presence  of the place and time that look it up (Warp); 0: the mean over time
  Radiance radiance(Vec3 x_canonical, float presence = 0) const;
  /// Of what x shows at this time, 1 / scene unit.
  float density(Vec3 x) const;

 private:
  struct Views;
  std::shared_ptr<const Views> views_;
};

/// Where a material point is at a time.
struct TrackedPoint {
  Vec3 position;        ///< scene units
  bool folded = false;  ///< the way there led through a fold, a jump or a place the warp does not reach: do
                        ///< not trust it
  float density = 0;    ///< of what is there, 1 / scene unit; not told of canonical places
};

/// Carries points of one time to other times. A point keeps its canonical place x + Delta(x, t); at every
/// other time it is where the warp looks that place up. The inverse is found by going through time in short
/// steps, each predicted by the material velocity and corrected by invert_warp, so that of several places
/// that look alike the one reached by moving is taken.
/// @param from  model time of the points; times beyond [0, 1] are clamped.
/// @return [times][points]
std::vector<std::vector<TrackedPoint>> track(const VoxelModel& model, std::span<const Vec3> points,
                                             double from, std::span<const double> times);

/// The same for points of times of their own. @param from  [points]
std::vector<std::vector<TrackedPoint>> track(const VoxelModel& model, std::span<const Vec3> points,
                                             std::span<const double> from, std::span<const double> times);

/// The canonical places x + Delta(x, t) of points of one time; `folded` where the warp there is no longer one
/// to one.
std::vector<TrackedPoint> to_canonical(const VoxelModel& model, std::span<const Vec3> points, double time);
/// The same for points of times of their own. @param time  [points]
std::vector<TrackedPoint> to_canonical(const VoxelModel& model, std::span<const Vec3> points,
                                       std::span<const double> time);

}  // namespace splinevox
