// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "splinevox/field/model.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Finds where on a lattice in observed space a model can have matter, without sampling every voxel of its
/// box.
class MatterReach {
 public:
  /// @param min_density  1 / scene unit; less than that counts as empty.
  MatterReach(const VoxelModel& model, float min_density);

  /// Leaves (coordinates: voxel / 8) of the lattice that may hold a voxel of at least min_density: those
  /// whose box, moved by anything the motion field can do inside it, touches a canonical brick that is dense
  /// enough. Conservative: Delta = r * D, both trilinear, so inside a leaf it lies within the product of
  /// their ranges over the motion vertices around it, and presence below its largest there. In the order of
  /// the coordinates, x slowest.
  /// @param weights  of the control points at the time
  std::vector<Int3> candidates(const Lattice& out, const BasisWeights<float>& weights) const;

 private:
  /// Any brick that is dense enough with so much presence, and that a sample in this canonical box reads?
  bool occupied(Vec3 lo, Vec3 hi, float presence) const;
  float peak(Int3 brick) const;  ///< the largest raw density of a brick

  const VoxelModel& model_;
  float raw_min_ = 0;         ///< raw density of min_density
  std::vector<float> peaks_;  ///< [bricks + 1]
  Int3 bricks_{};             ///< bricks per axis of the radiance lattice
  std::vector<std::int32_t>
      sums_;  ///< [(x + 1) * (y + 1) * (z + 1)] dense bricks below a corner: a summed-area table
};

}  // namespace splinevox
