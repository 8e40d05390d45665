// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "core/simd.hpp"
#include "field/cells.hpp"
#include "field/lattice/brick_view.hpp"
#include "field/lattice/slice.hpp"
#include "math/warp.hpp"

namespace splinevox {

/// x + Delta(x) of a slice at the centres of a grid's cells. What a coordinate means for the lattice is
/// looked up in a table per axis: finding the rows would cost more than reading them.
class WarpedCenters {
 public:
  WarpedCenters(const VoxelModel& model, const MotionSlice& slice, const CellGrid& grid)
      : view_(*slice.topology),
        values_(slice.values.data()),
        rigidity_(model.motion.rigidity),
        offset_(model.motion.rigidity_offset) {
    const std::int32_t slots[3] = {view_.stride_x, view_.stride_y, 1}, locals[3] = {64, 8, 1};
    for (int a = 0; a < 3; ++a) {
      axis_[a].resize(grid.size[a]);
      for (int c = 0; c < grid.size[a]; ++c) {
        // The last block of an axis may reach beyond the box, where nothing is stored.
        const float x = std::min(grid.center({c, c, c})[a], model.box.hi[a]), u = view_.coordinate(x, a);
        const int vertex = int(u);
        axis_[a][c] = {{(vertex >> 3) * slots[a], (vertex & 7) * locals[a]}, u - float(vertex), x};
      }
    }
  }

  Vec3 operator()(Int3 c) const { return at(c).position; }

  struct Warped {
    Vec3 position;   ///< x + Delta(x)
    float presence;  ///< the largest of the corners of the motion cell
  };
  Warped at(Int3 c) const {
    using Four = Simd<float>::Four;
    const Entry &x = axis_[0][c.x], &y = axis_[1][c.y], &z = axis_[2][c.z];
    const CellRows rows =
        view_.rows({x.cell.slot + y.cell.slot + z.cell.slot, x.cell.local + y.cell.local + z.cell.local});
    float w[kCorners];
    trilinear_weights(Vec3{x.fraction, y.fraction, z.fraction}, w);
    Four m{};
    float presence = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < kCorners; ++i) {
      const float* row = values_ + std::size_t(rows.row[i]) * kSliceWidth;
      m += w[i] * load<Four>(row);
      presence = std::max(presence, row[kSliceScalars + kPresence]);
    }
    const float r = rigidity_ ? rigidity_of(m[3], offset_).value : 1.0f;
    return {Vec3{x.position, y.position, z.position} + displacement_of(m, r), presence};
  }

 private:
  struct Entry {
    Cell cell;  ///< this axis' share of slot and local
    float fraction, position;
  };
  BrickView<float> view_;
  const float* values_;
  bool rigidity_;
  float offset_;
  std::vector<Entry> axis_[3];
};

}  // namespace splinevox
