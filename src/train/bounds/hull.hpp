// SPDX-License-Identifier: Apache-2.0
#pragma once

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
/// cell is kept if for some window of neighbouring times every view of the window sees it inside the object's
/// silhouette (grown by a few pixels), so the hull covers the swept volume and never assumes that the object
/// was static for longer than a window.
/// @param cells   of the returned hull along the longest edge.
/// @param margin  added around the hull's box, share of its longest edge.
SceneBounds find_bounds(const Split& train, bool has_alpha, int cells, float margin);

}  // namespace splinevox
