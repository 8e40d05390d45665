// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/atomic.hpp"
#include "core/team.hpp"
#include "math/trilinear.hpp"
#include "render/shade.hpp"

namespace splinevox {

/// Gradient rows that many rays add to at once. Sums of floats depend on the order in which rays arrive; sums
/// of whole numbers do not, so that gradients in fixed point have the same bits in every run, on any device,
/// for any number of threads.
struct GradientRows {
  static constexpr double kUnit = 0x1p40;     ///< in fixed point, a gradient of 1
  static constexpr float kLargest = 0x1p16f;  ///< in fixed point, of one sample: 128 such still fit
  float* values = nullptr;                    ///< [rows * width]
  std::int64_t* fixed = nullptr;              ///< [rows * width] used instead of values; null: values are
  std::uint64_t* touched = nullptr;           ///< [rows / 64] one bit per row: RowMask's words
  int width = 0;
  std::uint64_t* marks =
      nullptr;  ///< [rows / 64] the same for what becomes LearnedRows::visible; null: not kept

  SPLINEVOX_HD void add(std::size_t i, float x) const {
    if (fixed)
      atomic_add(fixed + i, std::int64_t(double(x) * kUnit));
    else
      atomic_add(values + i, x);
  }
};

/// Gradients of a team's samples on their way to the rows: [kLanes] of kRow floats, one bank further for
/// every lane.
template <bool Jet>
struct Stage {
  static constexpr int kColumns = 8, kJet = Jet ? 12 : 0, kRow = kColumns + kJet + 1;
  static constexpr std::size_t kBytes = std::size_t(kLanes) * kRow * sizeof(float);
  float* values;
  SPLINEVOX_INLINE float* row(int lane) const { return values + lane * kRow; }
};

/// Adds what the lanes staged to columns [offset, offset + used) of the rows around their places: corner c
/// receives w_c g, with Slopes also sum_j (d w_c / d f_j) h[j] in the first four columns.
///
/// Eight lanes take one column each and go through eight samples in order. Successive samples of a ray share
/// cells, so they are summed while the cell stays the same; then one addition per corner covers a row's 32
/// bytes with eight neighbouring lanes.
/// @param keep  lanes that have something, one bit each.   @param mark  whether to mark the rows touched, and
/// those around the lanes of `visible` as visible.
template <bool Slopes, bool Jet, class Team>
SPLINEVOX_HD void accumulate(const Team& team, const BrickView<float>& view,
                             const typename Team::template Lanes<Place>& places, std::uint32_t keep,
                             std::uint32_t visible, const Stage<Jet>& stage, int offset, int used, bool mark,
                             const GradientRows& out) {
  team.each([&](int lane) {
    const int column = lane & 7, first = lane & ~7;
    float sum[kCorners] = {};
    Cell run{-1, 0};
    std::uint32_t any_visible = 0;
    const auto flush = [&] {
      const CellRows rows = view.rows(run);
      std::int32_t own = 0;
      SPLINEVOX_UNROLL for (int c = 0; c < kCorners; ++c) {
        if (c == column) own = rows.row[c];
        if (column < used && rows.row[c] >= kBrickRows)
          out.add(std::size_t(rows.row[c]) * out.width + offset + column, sum[c]);
        sum[c] = 0;
      }
      if (mark && own >= kBrickRows) atomic_or(out.touched + (own >> 6), std::uint64_t(1) << (own & 63));
      if (mark && any_visible && own >= kBrickRows)
        atomic_set(out.marks + (own >> 6), std::uint64_t(1) << (own & 63));
      any_visible = 0;
    };
    for (int j = 0; j < Stage<Jet>::kColumns; ++j) {
      const Place at = team.at(places, first + j);
      if (!(keep >> (first + j) & 1)) continue;
      if (run.slot >= 0 && (run.slot != at.cell.slot || run.local != at.cell.local)) flush();
      run = at.cell;
      any_visible |= visible >> (first + j) & 1;
      float w[kCorners];
      trilinear_weights(at.fraction, w);
      const float* row = stage.row(first + j);
      SPLINEVOX_UNROLL for (int c = 0; c < kCorners; ++c) sum[c] += w[c] * row[column];
      if constexpr (Slopes)
        if (column < 4) {
          Vec3 d[kCorners];
          trilinear_weight_gradients(at.fraction, d);
          SPLINEVOX_UNROLL for (int c = 0; c < kCorners; ++c) SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a)
              sum[c] += d[c][a] * row[8 + 4 * a + column];
        }
    }
    if (run.slot >= 0) flush();
  });
}

}  // namespace splinevox
