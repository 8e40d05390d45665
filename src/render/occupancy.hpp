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

  /// Calls open = begin(level, first) for eight blocks beside each other, `first` and those towards +x, +y
  /// and +z, then open(corner, block) for those in the grid. First for the blocks of the top, and then for
  /// the parts of each block of which it returns true, down to the cells, level 0.
  template <class Begin>
  void descend(const Begin& begin) const {
    const Int3 size = levels[kLevels - 1].size;
    Int3 c;
    for (c.x = 0; c.x < size.x; c.x += 2)
      for (c.y = 0; c.y < size.y; c.y += 2)
        for (c.z = 0; c.z < size.z; c.z += 2) eight(c, kLevels - 1, begin);
  }

 private:
  template <class Begin>
  void eight(const Int3& first, int level, const Begin& begin) const {
    auto open = begin(level, first);
    const Int3 size = levels[level].size;
    for (int i = 0; i < kCorners; ++i) {
      const Int3 c = first + corner(i);
      if (c.x < size.x && c.y < size.y && c.z < size.z && open(i, c) && level > 0)
        eight(2 * c, level - 1, begin);
    }
  }
};

/// Cells of observed space that may hold matter at the slice's time: those whose centre is warped into an
/// occupied canonical cell, and of a model with presence where the density is enough at that time.
BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice, const OccupancyPyramid& canonical);

}  // namespace splinevox
