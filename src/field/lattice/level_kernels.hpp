// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/atomic.hpp"
#include "core/pack.hpp"
#include "field/columns.hpp"
#include "field/lattice/lattice_view.hpp"
#include "field/lattice/row_slope.hpp"
#include "field/lattice/slice.hpp"

/// The motion levels and slices of levels.hpp and slice.hpp, one element at a time and without one element
/// writing what is another's: the adjoints gather where the loops over bricks scatter.
namespace splinevox {

/// One pack of one row: the level, plus what the sum of the coarser ones is there (prolong_brick).
struct CollapseKernel {
  const float* level;
  const float* coarse_sum;  ///< null: this is the coarsest level
  float* sum;
  LatticeView lattice, coarse;
  const std::uint64_t* rows;  ///< those to do; null: all
  int width;

  SPLINEVOX_HD std::size_t count() const { return lattice.rows() * std::size_t(width / Pack::kSize); }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    const int packs = width / Pack::kSize, offset = int(i % packs) * Pack::kSize;
    const std::size_t row = i / packs;
    if (rows && !test_row(rows, row)) return;
    Pack out = load_pack(level + row * width + offset);
    if (coarse_sum && row >= kBrickRows) {
      const Int3 v = lattice.vertex(row);
      const float weight = 1.0f / float(1 << ((v.x & 1) + (v.y & 1) + (v.z & 1)));
      for (int x = v.x >> 1; x <= (v.x + 1) >> 1; ++x)
        for (int y = v.y >> 1; y <= (v.y + 1) >> 1; ++y)
          for (int z = v.z >> 1; z <= (v.z + 1) >> 1; ++z)
            out += weight * load_pack(coarse_sum + coarse.row_of({x, y, z}) * width + offset);
    }
    store_pack(sum + row * width + offset, out);
  }
};

/// Basis weights of the time of one slot, and which of them are not zero.
struct SlotWeights {
  BasisWeights<float> w;
  int first, last;
};

inline SlotWeights slot_weights(const BasisWeights<float>& w, int stored_points) {
  SlotWeights s{w, 0, stored_points};
  while (s.last > 0 && s.w[s.last - 1] == 0) --s.last;
  while (s.first < s.last && s.w[s.first] == 0) ++s.first;
  return s;
}

/// One row: the slices of all slots (contract_brick).
struct ContractKernel {
  MotionLayout layout;
  const float* level;
  const std::uint64_t* active;  ///< rows to do
  const SlotWeights* slots;
  const float* mean;  ///< [points] of presence: mean_weights; null: there is none
  int points;         ///< stored
  int slot_count;
  std::size_t rows;
  float* slices;  ///< [slots * rows * kSliceWidth]

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t r) const {
    if (!test_row(active, r)) return;
    const float* row = level + r * layout.width;
    float centre = 0;
    if (mean)
      for (int k = 0; k < points; ++k) centre += mean[k] * row[layout.stride * k + layout.scalar[kPresence]];
    for (int s = 0; s < slot_count; ++s) {
      const SlotWeights& slot = slots[s];
      Pack sum{}, scalars{};
      for (int k = slot.first; k < slot.last; ++k) {
        const float* p = row + layout.stride * k;
        const float w = slot.w[k];
        if (layout.displaces) sum += w * Pack{{p[0], p[1], p[2], 0}};
        SPLINEVOX_UNROLL for (int i = 0; i < kScalars; ++i) {
          if (layout.scalar[i] >= 0) scalars[i] += w * p[layout.scalar[i]];
        }
      }
      scalars[kPresence] -= centre;
      if (layout.rigidity) sum[3] = row[layout.rigidity_column];
      float* out = slices + (s * rows + r) * kSliceWidth;
      store_pack(out, sum);
      store_pack(out + kSliceScalars, scalars);
    }
  }
};

/// One row: its gradient from those of all slots' slices (expand_brick), which it clears.
struct ExpandKernel {
  MotionLayout layout;
  const std::uint64_t* touched;  ///< rows that any slot has something for
  const std::uint64_t* active;   ///< rows that are learned
  const SlotWeights* slots;
  const float* mean;  ///< as ContractKernel's
  int points;         ///< stored
  int slot_count;
  std::size_t rows;
  float* slices;    ///< [slots * rows * kSliceWidth] gradients
  float* gradient;  ///< [rows * width] added to

  SPLINEVOX_HD std::size_t count() const { return rows; }
  SPLINEVOX_HD void operator()(std::size_t r) const {
    if (!test_row(touched, r)) return;
    const bool learned = test_row(active, r);
    float* row = gradient + r * layout.width;
    float present = 0;
    for (int s = 0; s < slot_count; ++s) {
      float* from = slices + (s * rows + r) * kSliceWidth;
      if (!learned) {
        store_pack(from, {});
        store_pack(from + 4, {});
        continue;
      }
      const Pack g = load_pack(from), scalars = load_pack(from + kSliceScalars);
      if (layout.rigidity) row[layout.rigidity_column] += g[3];
      present += scalars[kPresence];
      const SlotWeights& slot = slots[s];
      for (int k = slot.first; k < slot.last; ++k) {
        float* p = row + layout.stride * k;
        const float w = slot.w[k];
        if (layout.displaces)
          for (int a = 0; a < 3; ++a) p[a] += w * g[a];
        SPLINEVOX_UNROLL for (int i = 0; i < kScalars; ++i) {
          if (layout.scalar[i] >= 0) p[layout.scalar[i]] += w * scalars[i];
        }
      }
      store_pack(from, {});
      store_pack(from + 4, {});
    }
    if (mean)
      for (int k = 0; k < points; ++k) row[layout.stride * k + layout.scalar[kPresence]] -= mean[k] * present;
  }
};

/// Some rows of one slot: their share of d loss / d time (slope_brick). Before ExpandKernel, which clears
/// what this one reads.
struct SlopeKernel {
  static constexpr std::size_t kRows = 256;  ///< of one share
  MotionLayout layout;
  const float* level;
  const std::uint64_t *touched, *active;  ///< rows that have something, and those that are learned
  const SlotWeights* slots;               ///< weights of the time derivative
  int slot_count;
  std::size_t rows;
  const float* slices;  ///< [slots * rows * kSliceWidth] gradients
  double* parts;        ///< [shares * slots]

  SPLINEVOX_HD static std::size_t shares(std::size_t rows) { return (rows + kRows - 1) / kRows; }
  SPLINEVOX_HD std::size_t count() const { return shares(rows) * std::size_t(slot_count); }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    const std::size_t s = i % std::size_t(slot_count), first = i / std::size_t(slot_count) * kRows,
                      last = first + kRows < rows ? first + kRows : rows;
    const SlotWeights& slot = slots[s];
    double sum = 0;
    for (std::size_t r = first; r < last; ++r)
      if (test_row(touched, r) && test_row(active, r))
        sum += row_slope(layout, level + r * layout.width, slot.w, slot.first, slot.last,
                         slices + (s * rows + r) * kSliceWidth);
    parts[i] = sum;
  }
};

/// One pack of one coarse row: the transpose of the prolongation, from the 27 fine rows around it
/// (restrict_brick).
struct RestrictKernel {
  const float* fine_gradient;
  const std::uint64_t* fine_touched;
  float* gradient;         ///< of the coarse level, added to
  std::uint64_t* touched;  ///< of the coarse level
  LatticeView fine, coarse;
  int width;

  SPLINEVOX_HD std::size_t count() const { return coarse.rows() * std::size_t(width / Pack::kSize); }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    const int packs = width / Pack::kSize, offset = int(i % packs) * Pack::kSize;
    const std::size_t row = i / packs;
    if (row < kBrickRows) return;
    const Int3 centre = 2 * coarse.vertex(row);
    Pack sum{};
    bool any = false;
    for (int d = 0; d < 27; ++d) {
      const Int3 step{d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1};
      const std::size_t from = fine.row_of(centre + step);
      if (from < kBrickRows || !test_row(fine_touched, from)) continue;
      any = true;
      const int odd = (step.x != 0) + (step.y != 0) + (step.z != 0);
      sum += (1.0f / float(1 << odd)) * load_pack(fine_gradient + from * width + offset);
    }
    if (!any) return;
    float* to = gradient + row * width + offset;
    store_pack(to, load_pack(to) + sum);
    if (offset == 0) atomic_or(touched + (row >> 6), std::uint64_t(1) << (row & 63));
  }
};

}  // namespace splinevox
