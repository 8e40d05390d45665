// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/occupancy.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Where the scene can be at all.
struct SceneBounds {
  Box box;       ///< scene units
  BitGrid hull;  ///< over the box: cells that some short window of time leaves possible
};

/// Bounds from the cameras and, where there is alpha, from silhouettes.
///
/// Start: a cube around the point closest to all viewing axes, as large as the views are at that distance. A
/// cell is kept if for some window of neighbouring times no view of the window sees it outside the object's
/// silhouette (grown by a few pixels), and most see it inside, so the hull covers the swept volume and never
/// assumes that the object was static for longer than a window.
/// @param cells   of the returned hull along the longest edge.
/// @param margin  added around the hull's box, share of its longest edge.
SceneBounds find_bounds(const Split& train, bool has_alpha, int cells, float margin);

/// The cameras of a split's frames.
std::vector<Camera> cameras_of(const Split& split);

/// Cube around the point nearest to all viewing axes: as large as the views of cameras that look at it. If
/// most look away from it they are inside the scene, which a cube between them would not hold (numerics H28).
Box camera_cube(const std::vector<Camera>& cameras);

/// Whether all cameras look in one direction, so that no point is nearest to what they look at.
bool look_alike(const std::vector<Camera>& cameras);

/// The share of what the silhouettes show that their hull can show, 0..1: of pixels with alpha, whose rays
/// meet a cell that views of about the same time agree on. Near 1 where cameras belong to the pictures; far
/// below where they do not, because silhouettes of other cameras meet nowhere.
/// @param cameras  instead of the split's own, one per frame.
double explained_by_hull(const Split& train, const std::vector<Camera>& cameras);

/// Cameras that others may have been written for: the same numbers with other axes, or the other way round.
struct OtherCameras {
  const char* what;  ///< what the matrices seem to be
  std::vector<Camera> cameras;
};
std::vector<OtherCameras> other_cameras(const Split& train);

/// How far apart the cameras see the middle of the box, degrees: the largest angle between two of its views.
/// Below one the depth of a static scene is not determined.
double parallax(const std::vector<Camera>& cameras, const Box& box);

}  // namespace splinevox
