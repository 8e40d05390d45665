// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "math/least_squares.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {

/// Operations on the motion of a finished model, for `edit`. All keep the light beside the control points:
/// what changes the course of time or the basis changes both, what changes places changes the control points
/// alone.
/// @pre everywhere: at most one motion level, as a saved model has.

/// time_curve(new time) = time_curve(change(new time)). Exact: no control point is touched.
void retime(MotionField& motion, const TimeCurve& change);

/// Every displacement times `factor`; canonical places and light stay.
void scale_motion(MotionField& motion, float factor);

/// The same motion with other control points: new point k = sum_j map(k, j) old point j, for control points
/// and light, summed in double. @param map  [points x motion.points]; a pinned first point counts as zero and
/// is left out of what is stored.
MotionField with_points(const MotionField& motion, BasisKind basis, int points, FirstPoint first,
                        const Matrix& map);

/// Degree elevation by `by` in one step. @pre the basis elevates
MotionField elevated(const MotionField& motion, int by);

/// The curves in another basis, nearest in the mean square over the parameter; where the new basis holds the
/// old curves exactly (a B-spline in poly-Bezier pieces of the same spans, a higher degree, ...) they come
/// out exactly, to rounding. A curve that begins in zero keeps doing so if the new basis is pinnable. @pre
/// the basis allows so many points
MotionField converted(const MotionField& motion, BasisKind basis, int points);

/// The middles of `count` equal parts of [0, 1]: parameters at which curves are compared or fitted.
std::vector<double> middles(int count);

/// Weights of every point of a basis at every sample: [samples x points].
Matrix design(BasisKind basis, int points, const std::vector<double>& samples);

/// Control points that give curves of this basis through (nearest to) samples: [points x samples.size()],
/// first row and column zero if the first point is pinned. @param samples  parameters in [0, 1], more than
/// points
Matrix fit_matrix(BasisKind basis, int points, FirstPoint first, const std::vector<double>& samples);

/// One place of observed space that shows matter.
struct Shown {
  Vec3 x;                   ///< observed
  FrameSampler::Warp warp;  ///< there
  float weight;             ///< opacity over one voxel, (0, 1]
};

/// Calls visit(slab, shown) for every `stride`th vertex of the radiance lattice, anywhere in the box, that
/// shows matter at a parameter of the curves. Slabs run in parallel; within one the order is fixed. Returns
/// nothing; there are `shown_slabs` slabs.
void visit_shown(const VoxelModel& model, double parameter, int stride,
                 const std::function<void(int slab, const Shown&)>& visit);
int shown_slabs(const VoxelModel& model, int stride);

/// Distance in voxels of the radiance lattice, over what is shown at evenly spread parameters, weighted by
/// opacity.
struct MotionDifference {
  double max = 0, rms = 0;
};
/// Adds distances up to one.
struct DistanceSum {
  double max = 0, squares = 0, weight = 0;
  void add(double distance, double w) {
    max = std::max(max, distance), squares += w * distance * distance, weight += w;
  }
  void add(const DistanceSum& o) { max = std::max(max, o.max), squares += o.squares, weight += o.weight; }
  MotionDifference result() const { return {max, weight > 0 ? std::sqrt(squares / weight) : 0}; }
};
/// Of the displacements of two models of one scene: `after` differs in its control points alone.
MotionDifference motion_difference(const VoxelModel& before, const VoxelModel& after);

}  // namespace splinevox
