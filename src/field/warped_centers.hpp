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
      axis_[a].resize(std::size_t(grid.size[a] + grid.size[a] % 2));
      for (int c = 0; c < int(axis_[a].size()); ++c) {
        // The last block of an axis may reach beyond the box, where nothing is stored.
        const float x = std::min(grid.center({c, c, c})[a], model.box.hi[a]), u = view_.coordinate(x, a);
        const int vertex = int(u);
        axis_[a][c] = {{(vertex >> 3) * slots[a], (vertex & 7) * locals[a]}, u - float(vertex), x};
      }
    }
  }

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

  /// The same of eight cells, in the order of a cell's corners.
  struct Eight {
    float position[3][kCorners], presence[kCorners];
    Vec3 at(int i) const { return {position[0][i], position[1][i], position[2][i]}; }
  };
  /// The cells `first` and those beside it towards +x, +y and +z; those beyond the grid are of no use. Where
  /// they lie in one motion cell, its rows are read once.
  Eight eight(Int3 first) const {
    const Entry *x = &axis_[0][first.x], *y = &axis_[1][first.y], *z = &axis_[2][first.z];
    Eight out;
    const auto same = [](const Entry* e) {
      return e[0].cell.slot == e[1].cell.slot && e[0].cell.local == e[1].cell.local;
    };
    if (!same(x) || !same(y) || !same(z)) {
      for (int i = 0; i < kCorners; ++i) {
        const Warped w = at(first + corner(i));
        for (int a = 0; a < 3; ++a) out.position[a][i] = w.position[a];
        out.presence[i] = w.presence;
      }
      return out;
    }
    const CellRows rows = view_.rows(
        {x->cell.slot + y->cell.slot + z->cell.slot, x->cell.local + y->cell.local + z->cell.local});
    float weights[kCorners][kCorners];  // [corner][cell]
    for (int i = 0; i < kCorners; ++i) {
      const Int3 side = corner(i);
      const Entry *ex = x + side.x, *ey = y + side.y, *ez = z + side.z;
      float w[kCorners];
      trilinear_weights(Vec3{ex->fraction, ey->fraction, ez->fraction}, w);
      for (int c = 0; c < kCorners; ++c) weights[c][i] = w[c];
      out.position[0][i] = ex->position;
      out.position[1][i] = ey->position;
      out.position[2][i] = ez->position;
    }
    float m[4][kCorners] = {}, presence = -std::numeric_limits<float>::infinity();
    for (int c = 0; c < kCorners; ++c) {
      const float* row = values_ + std::size_t(rows.row[c]) * kSliceWidth;
      for (int k = 0; k < 4; ++k)
        for (int i = 0; i < kCorners; ++i) m[k][i] += weights[c][i] * row[k];
      presence = std::max(presence, row[kSliceScalars + kPresence]);
    }
    for (int i = 0; i < kCorners; ++i) {
      const float r = rigidity_ ? rigidity_of(m[3][i], offset_).value : 1.0f;
      const float own[] = {m[0][i], m[1][i], m[2][i]};
      const Vec3 delta = displacement_of(own, r);
      for (int a = 0; a < 3; ++a) out.position[a][i] += delta[a];
      out.presence[i] = presence;
    }
    return out;
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
