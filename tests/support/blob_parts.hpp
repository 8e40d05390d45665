// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/field/edit.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox::test {

/// Parts of blob_model: four quarters around the axis of its ball along z, which meet in it.
inline MotionClusters quarters(const VoxelModel& model) {
  MotionClusters out;
  out.cells = model.radiance.raw.topology->lattice;
  out.clusters.resize(4);
  for (int x = 0; x < out.cells.size.x; ++x)
    for (int y = 0; y < out.cells.size.y; ++y)
      for (int z = 0; z < out.cells.size.z; ++z) {
        const Vec3 p = out.cells.position({x, y, z});
        out.label.push_back(2 * (p.x > 0.1f) + (p.y > -0.05f));
      }
  return out;
}

}  // namespace splinevox::test
