// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "splinevox/field/model.hpp"

namespace splinevox {

// Operations on a finished model, for `edit`. Those on motion keep the light beside the control points: what
// changes the course of time or the basis changes both, what changes places changes the control points alone.
// Everywhere: at most one motion level, as a saved model has.

/// time_curve(new time) = time_curve(change(new time)). Exact: no control point is touched.
void retime(MotionField& motion, const TimeCurve& change);

/// Every displacement times `factor`; canonical places and light stay.
void scale_motion(MotionField& motion, float factor);

/// Changes the motion. Where matter comes and goes, places that were emptied stay empty at all times: another
/// presence may look them up then, and what was hidden must not come back.
void keep_emptied(VoxelModel& model, const std::function<void(MotionField&)>& change);

/// Presence times `factor`: 0 leaves the mean of the raw density at every time.
void scale_presence(MotionField& motion, float factor);

/// Matter stays as it is at one time: the presence of that time becomes part of the canonical density, where
/// that time shows it, and the model has none. Motion and light stay.
void freeze_presence(VoxelModel& model, double time);

/// Degree elevation by `by` in one step. @pre the basis elevates
MotionField elevated(const MotionField& motion, int by);

/// The curves in another basis, nearest in the mean square over the parameter; where the new basis holds the
/// old curves exactly (a B-spline in poly-Bezier pieces of the same spans, a higher degree, ...) they come
/// out exactly, to rounding. A curve that begins in zero keeps doing so if the new basis is pinnable. @pre
/// the basis allows so many points
MotionField converted(const MotionField& motion, BasisKind basis, int points);

/// Over the matter of observed space at evenly spread parameters.
struct MotionDifference {
  double max = 0, rms = 0;  ///< distance in voxels of the radiance lattice; rms: weighted by opacity
  double light = 0;         ///< the largest difference of the gain of the light
  double opacity = 0;       ///< and of the opacity over a voxel, by presence alone
};
/// Of two models of one scene, whose canonical matter is the same but for what is emptied.
MotionDifference motion_difference(const VoxelModel& before, const VoxelModel& after);

/// Makes the first moment canonical: Delta(x, t = 0) = 0, and the scene looks as before at every time.
///
/// Subtracting the first displacement from every curve would do the first alone: the canonical volume has to
/// come along. It becomes observed space at time 0, C'(y) = C(W_0(y)), and the curves lead to where that is,
/// W_0(x + Delta'(x, t)) = W_t(x), which is solved at many moments by inverting W_0 and fitted in the same
/// basis; then Delta'(x, 0), next to nothing, is taken off every curve. Without motion at time 0 this is the
/// subtraction. Light and presence stay: they are those of a place in observed space. The canonical volume
/// keeps what is there at any time.
/// @pre at most one motion level, model.motion.moves()
/// @return the distance between W_0(x + Delta') and W_t(x), which includes places whose canonical matter is
/// absent from observed space at time 0; nothing of light and opacity
MotionDifference anchor_first(VoxelModel& model);

/// What remove_floaters took away, and left.
struct RemovedFloaters {
  int count = 0, left = 0;  ///< pieces
  double share = 0;         ///< of all solid matter, by opacity, that went
};

/// Takes small pieces out of the canonical volume. A piece is made of vertices that lie next to each other,
/// corners included, and have at least 5% opacity over a voxel at some time. It floats if it has less than
/// `least` of all matter in pieces, by opacity when there is most. Thinner matter up to two voxels around
/// goes with it, but not beside what stays. Motion stays.
RemovedFloaters remove_floaters(VoxelModel& model, double least);

/// Which parts of the canonical volume move alike.
///
/// A motion voxel belongs to observed space and holds different matter at different times, so its control
/// points are the path of no matter. What is clustered is the path of the matter: every place with matter at
/// a time adds its own position to the canonical cell that it looks up, weighted by opacity; the mean over
/// the moments of a cell's path is its trajectory, taken relative to its own mean place. Gaps, where a cell
/// is out of sight, are filled from the moments around them.
struct MotionClusters {
  struct Cluster {
    double share = 0;   ///< of all matter, by opacity
    double motion = 0;  ///< root mean square of the distance from the own mean place over the moments, voxels
                        ///< of the radiance lattice
    Vec3 center{};      ///< of its canonical cells, scene units
  };
  Lattice cells;  ///< canonical cells, each around a vertex of this lattice
  std::vector<std::int16_t>
      label;  ///< [cells, z fastest] number of the cluster; -1: no place ever looks up matter here
  std::vector<Cluster> clusters;  ///< 0 is static: moves by less than kStillVoxels, or by little and like
                                  ///< no moving part; then the less a cluster moves the earlier
  double silhouette = 0;          ///< see math/kmeans.hpp

  /// Cluster of a canonical position, -1 for none.
  int at(Vec3 canonical) const;
};

inline constexpr double kStillVoxels = 0.5;  ///< MotionClusters::Cluster::motion below which a cell is static

inline constexpr int kMostClusters = 16;

/// @param count  clusters, the static one included, 2 to kMostClusters; 0: the fewest, up to 6, whose
/// silhouette is within 0.03 of the highest. Deterministic. The time curve plays no part.
/// @pre at most one motion level. Where nothing moves there is one cluster.
MotionClusters find_clusters(const VoxelModel& model, int count);

/// Which clusters an operation means: [clusters]. Unlabelled places belong to none.
using ChosenClusters = std::vector<bool>;

/// Takes the matter of the chosen clusters out of the canonical volume, and so out of every time.
/// Motion stays.
void hide_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen);
/// Takes everything else out.
void keep_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen);
/// Gives the matter of the chosen clusters one colour from every side. @param color  display values in [0, 1]
void paint_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                    Vec3 color);

/// The nearest such colour that a model can have: a view factor that is the same from every side limits it.
Vec3 paintable(const VoxelModel& model, Vec3 color);

/// x -> turn (x - pivot) + pivot + offset
struct RigidMotion {
  Vec3d turn[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< rows of a rotation
  Vec3d pivot{}, offset{};
  Vec3d linear(const Vec3d& v) const { return {dot(turn[0], v), dot(turn[1], v), dot(turn[2], v)}; }
  Vec3d linear_inverse(const Vec3d& v) const { return v.x * turn[0] + v.y * turn[1] + v.z * turn[2]; }
  Vec3d operator()(const Vec3d& x) const { return linear(x - pivot) + pivot + offset; }
  Vec3d inverse(const Vec3d& x) const { return linear_inverse(x - pivot - offset) + pivot; }
};
/// @param axis  not zero; @param degrees  right-handed
RigidMotion rotation(const Vec3d& axis, double degrees, const Vec3d& pivot);

/// What an edit of one part does to the rest, and how well it could be done.
struct PartEdit {
  double disturbed = 0;  ///< share of the other matter, over all times, whose motion would change; [0, 1]
  double covered = 0;    ///< share of the part that would land where other canonical matter is; [0, 1]
  double ghosts = 0;     ///< share of the part that would still be visible where it was; [0, 1]
  double error_max = 0,
         error_rms = 0;  ///< voxels, over the part at all times: where it should be against where it is
};

/// Moves clusters rigidly, the whole of their motion with them, and grows the box where they leave it.
///
/// The warp is a backward warp: to move a part, its canonical matter, the control points of all its motion
/// voxels and the places that they look up are all carried along: W'(x) = G(W(G^-1 x)). That is possible only
/// where the new motion voxels serve no other matter at any time, and where the canonical volume has room.
/// Motion voxels that only the part used and left get no displacement.
/// @return how far that fails; with `disturbed`, `covered` or `ghosts` above `limit` the model is unchanged.
PartEdit carry_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                        const RigidMotion& g, double limit);

/// The motion of the clusters at F times the speed from time 0 on, at most to its end; the rest keeps its
/// own. Motion voxels that serve other matter as well at some time keep theirs: `disturbed` is here the share
/// of the part in such voxels.
/// Throws Error (input) where matter comes and goes in the part, since its presence would have another mean
/// over time, which the canonical volume holds.
/// @pre the identity as time curve. @return as carry_clusters; the error is that of the curves' fit.
PartEdit slow_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                       double factor, double limit);

}  // namespace splinevox
