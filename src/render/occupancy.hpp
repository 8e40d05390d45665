// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "field/cells.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/slice.hpp"
#include "render/views.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Cells with one bit each.
struct BitGrid : CellGrid {
  std::vector<std::uint32_t> bits;

  BitGrid() = default;
  explicit BitGrid(const CellGrid& cells);
  BitGrid(const Box& box, int cells_along_longest) : BitGrid(CellGrid(box, cells_along_longest)) {}
  bool test(std::size_t i) const { return bits[i >> 5] >> (i & 31) & 1; }
  void set(std::size_t i) { bits[i >> 5] |= 1u << (i & 31); }
  void clear(std::size_t i) { bits[i >> 5] &= ~(1u << (i & 31)); }
  std::size_t count() const;
  /// Whether any cell is set that a box, corners lo and hi, touches; clamped to the grid like cell_of.
  bool any(Vec3 lo, Vec3 hi) const;
  /// Cells set in either; the grids have the same cells.
  BitGrid& operator|=(const BitGrid& other);

  template <class Real = float>
  OccupancyView<Real> view() const {
    return {cast<Real>(origin), Real(1) / Real(cell), size, bits.data()};
  }
};

/// The grid grown by one cell in every direction, diagonals included.
BitGrid dilate(const BitGrid& grid);

/// The grid without its small parts: connected sets of cells (faces, edges or corners touching) with less
/// than `share` of all set cells. What floats alone is dropped; a horn stays, because it grows on something.
BitGrid drop_small_parts(const BitGrid& grid, float share);

/// Smallest box around the set cells, grown by `margin` times its longest edge. An empty grid gives the
/// grid's own box.
Box bounding_box(const BitGrid& grid, float margin);

/// Cells of the canonical volume that may hold matter: those within one radiance vertex of a vertex whose
/// alpha over `step` is at least `alpha` at some time, grown by one cell. That margin covers every position
/// of an observed cell when the warp stretches it by less than a factor of two.
BitGrid canonical_occupancy(const VoxelModel& model, int cells, float alpha, float step);
/// The same in the cells of presence that is known. @param presence  of this model
BitGrid canonical_occupancy(const VoxelModel& model, const LargestPresence& presence, float alpha,
                            float step);

/// What matter that comes and goes takes to be skipped: a cell holds none at a time where its largest raw
/// density and the presence there stay below a threshold. In cells and in blocks of 2 and 4 of them an edge.
struct PresencePeaks {
  float threshold = 0;           ///< raw density of the alpha that counts
  std::vector<CellValues> raw;   ///< [levels] largest raw density around canonical cells, as levels are grown
  std::vector<CellValues> most;  ///< [levels] largest presence at any time, of observed cells
};

/// A canonical occupancy and, above it, blocks of 2 and of 4 of its cells an edge with any cell set, grown by
/// one block.
struct OccupancyPyramid {
  static constexpr int kLevels = 3;
  std::array<BitGrid, kLevels> levels;
  std::array<BitGrid, kLevels>
      full;  ///< blocks with every cell set, in them and beside them; none of level 0
  std::array<BitGrid, kLevels>
      moving;  ///< those in which anything is displaced at any time; no cells: all may be
  std::optional<PresencePeaks> presence;  ///< of a model whose matter comes and goes; its levels have no bits
  /// @param reach  where something may be displaced, like the canonical grid (reach_of); no cells:
  /// everywhere.
  explicit OccupancyPyramid(BitGrid canonical, BitGrid reach = {});
  /// That of canonical_occupancy, or of a model with presence its peaks.
  OccupancyPyramid(const VoxelModel& model, int cells, float alpha, float step, BitGrid reach = {});

  /// Calls visit(level, block) for the blocks of the top and for the parts of those of which it returns true,
  /// down to the cells, level 0.
  template <class Visit>
  void descend(const Visit& visit) const {
    each({0, 0, 0}, levels[kLevels - 1].size, kLevels - 1, visit);
  }

 private:
  template <class Visit>
  void each(const Int3& first, const Int3& last, int level, const Visit& visit) const {
    Int3 c;
    for (c.x = first.x; c.x < last.x; ++c.x)
      for (c.y = first.y; c.y < last.y; ++c.y)
        for (c.z = first.z; c.z < last.z; ++c.z)
          if (visit(level, c) && level > 0)
            each(2 * c, min(levels[level - 1].size, 2 * c + Int3{2, 2, 2}), level - 1, visit);
  }
};

/// Cells of observed space that may hold matter at the slice's time: those whose centre is warped into an
/// occupied canonical cell, and of a model with presence where the density is enough at that time.
BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice, const OccupancyPyramid& canonical);

}  // namespace splinevox
