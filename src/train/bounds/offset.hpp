// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "field/lattice/brick_view.hpp"
#include "render/occupancy.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// A displacement that is the same at all times. Static matter may lie anywhere in the canonical volume, so
/// training leaves it a voxel or two away from where it is observed. A volume that is resampled once at the
/// offset needs no motion there.
class Offset {
 public:
  /// Trilinear between the centres of cells.
  /// @param cells  where the offset is known; elsewhere it is what lies between
  /// @param known  [cells] of those cells, scene units
  Offset(const BitGrid& cells, const std::vector<Vec3>& known);

  /// At a position; from the centres of the outermost cells on the same as there.
  Vec3 at(Vec3 x) const;
  /// The y with y + at(y) = z, by as many steps of fixed point iteration as offsets of a few voxels need.
  Vec3 undo(Vec3 z) const;

 private:
  Channels values_;  ///< x, y, z at the cells' centres
  BrickView<float> view_;
  Box centers_;
};

}  // namespace splinevox
