// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "core/simd.hpp"
#include "field/lattice/row_mask.hpp"
#include "render/records.hpp"

namespace splinevox {

/// Sums records into rows without locks and with the same bits for any number of threads: records are
/// counting-sorted by the brick that owns the rows, in task order, and each brick is summed by one thread. A
/// record whose cell straddles bricks is listed once in each. A brick's rows stay in the first-level cache
/// while it is summed.
///
/// Every task belongs to a slot, and every slot has rows of its own: the bin of a slot's brick is slot *
/// bricks + brick.
template <class Real, int N, bool Jet>
class Scatter {
 public:
  using Rec = Record<Real, N, Jet>;

  void begin(int tasks, int bricks, int slots = 1) {
    bricks_ = bricks;
    counts_.resize(std::size_t(tasks) * bricks);
    tasks_.assign(tasks, {});
    tasks_of_.resize(slots);
    begin_.resize(std::size_t(slots) * bricks + 1);
  }
  /// Counts a task's records. Tasks may call this at the same time; the records must stay in place until
  /// reduce is done.
  void count(int task, const std::vector<Rec>& records, const BrickView<Real>& view, int slot) {
    tasks_[task] = {records.data(), records.size(), slot};
    std::uint32_t* counts = counts_of(task);
    std::memset(counts, 0, sizeof(std::uint32_t) * bricks_);
    for (const Rec& record : records)
      for_bricks(record.cell, view, [&](std::int32_t brick, int, int, int) { ++counts[brick]; });
  }
  /// Turns counts into positions; call once, after all tasks have counted.
  void scan() {
    for (std::vector<int>& tasks : tasks_of_) tasks.clear();
    for (std::size_t t = 0; t < tasks_.size(); ++t) tasks_of_[tasks_[t].slot].push_back(int(t));
    std::uint32_t total = 0, *begin = begin_.data();
    for (const std::vector<int>& tasks : tasks_of_)
      for (int b = 0; b < bricks_; ++b) {
        *begin++ = total;
        for (const int t : tasks) total += std::exchange(counts_of(t)[b], total);
      }
    *begin = total;
    entries_.resize(total);
  }
  /// Lists a task's records under their bricks. Tasks may call this at the same time.
  void fill(int task, const BrickView<Real>& view) {
    const Task& t = tasks_[task];
    std::uint32_t* next = counts_of(task);
    for (std::uint32_t i = 0; i < t.size; ++i)
      for_bricks(t.records[i].cell, view, [&](std::int32_t brick, int x, int y, int z) {
        entries_[next[brick]++] = {i, std::uint32_t(task),
                                   std::uint32_t((x + 1) << 8 | (y + 1) << 4 | (z + 1))};
      });
  }
  bool empty(int bin) const { return begin_[bin] == begin_[bin + 1]; }
  /// Adds one bin's records to its brick's rows ([512 * N]) and marks the rows touched. Bins are independent.
  void reduce(int bin, Real* rows, RowMask& touched) const {
    for (std::uint32_t e = begin_[bin]; e < begin_[bin + 1]; ++e) {
      if (e + kAhead < begin_[bin + 1]) {
        const Entry& next = entries_[e + kAhead];
        const char* record = reinterpret_cast<const char*>(tasks_[next.task].records + next.index);
        __builtin_prefetch(record);
        __builtin_prefetch(record + 64);
      }
      const Entry entry = entries_[e];
      add(tasks_[entry.task].records[entry.index], (entry.local >> 8) - 1, (entry.local >> 4 & 15) - 1,
          (entry.local & 15) - 1, rows, touched);
    }
  }

 private:
  static constexpr int kAhead = 6;
  struct Entry {
    std::uint32_t index;
    std::uint32_t task : 20,
        local : 12;  ///< local: base vertex relative to the bin's brick, -1..7 per axis, plus 1, 4 bits each
  };
  struct Task {
    const Rec* records = nullptr;
    std::size_t size = 0;
    int slot = 0;
  };

  std::uint32_t* counts_of(int task) { return counts_.data() + std::size_t(task) * bricks_; }

  template <class Visit>
  static void for_bricks(const Cell& cell, const BrickView<Real>& view, Visit&& visit) {
    const int x = cell.x(), y = cell.y(), z = cell.z();
    if (cell.interior()) {
      if (const std::int32_t brick = view.table[cell.slot]) visit(brick, x, y, z);
      return;
    }
    for (int dx = 0; dx <= (x == 7); ++dx)
      for (int dy = 0; dy <= (y == 7); ++dy)
        for (int dz = 0; dz <= (z == 7); ++dz)
          if (const std::int32_t brick = view.table[cell.slot + dx * view.stride_x + dy * view.stride_y + dz])
            visit(brick, x - 8 * dx, y - 8 * dy, z - 8 * dz);
  }

  static void add(const Rec& record, int x, int y, int z, Real* rows, RowMask& touched) {
    Real w[kCorners];
    trilinear_weights(record.fraction, w);
    Vec3T<Real> d[Jet ? kCorners : 1];
    if constexpr (Jet) trilinear_weight_gradients(record.fraction, d);
    const bool inside = ((x | y | z) >= 0) && x < 7 && y < 7 && z < 7;
    if (inside) {
      const std::uint64_t bits = std::uint64_t(0x303) << (y * 8 + z);
      touched.word[x] |= bits;
      touched.word[x + 1] |= bits;
    }
    for (int c = 0; c < kCorners; ++c) {
      const int cx = x + (c >> 2), cy = y + (c >> 1 & 1), cz = z + (c & 1);
      if (!inside) {
        if ((cx | cy | cz) < 0 || cx > 7 || cy > 7 || cz > 7) continue;
        touched.word[cx] |= std::uint64_t(1) << (cy * 8 + cz);
      }
      Real* row = rows + std::size_t(cx * 64 + cy * 8 + cz) * N;
      using Eight = typename Simd<Real>::Eight;
      for (int k = 0; k < N; k += 8) {
        Eight sum = load<Eight>(row + k) + w[c] * load<Eight>(record.g + k);
        if constexpr (Jet)
          for (int j = 0; j < 3; ++j) sum += d[c][j] * load<Eight>(record.h[j] + k);
        store(row + k, sum);
      }
    }
  }

  int bricks_ = 0;
  std::vector<std::uint32_t> counts_;  ///< [tasks * bricks], then where the next record goes
  std::vector<std::uint32_t> begin_;   ///< [bins + 1]
  std::vector<Task> tasks_;
  std::vector<std::vector<int>> tasks_of_;  ///< [slots]
  std::vector<Entry> entries_;
};

}  // namespace splinevox
