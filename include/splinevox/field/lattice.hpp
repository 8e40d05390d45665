// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "splinevox/core/aligned.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

inline constexpr int kBrick = 8;                             ///< vertices per brick edge: OpenVDB's leaf
inline constexpr int kBrickRows = kBrick * kBrick * kBrick;  ///< rows per brick

/// What is stored and read back (io/model_vdb.hpp) has no more: vertices of an axis, bricks of a lattice with
/// the ring around them.
inline constexpr int kMostVertices = 1 << 13;
inline constexpr double kMostBricks = 1 << 25;  ///< places of a table of bricks: 2500 vertices an axis

/// Regular lattice of vertices: vertex ijk sits at origin + spacing * ijk, as in OpenVDB
/// (a voxel's value is at its index, not half a voxel beside it).
struct Lattice {
  Vec3 origin{};
  float spacing = 1;  ///< scene units between vertices, > 0
  Int3 size{};        ///< vertices per axis, >= 2
  Vec3 position(Int3 ijk) const { return origin + spacing * cast<float>(ijk); }
  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// The lattice that covers `box` with `cells` cells along its longest edge and as many as needed along
/// the others. @pre cells >= 1, box not empty.
Lattice make_lattice(const Box& box, int cells);

/// The smallest spacing of a lattice, scene units: OpenVDB refuses a transform with smaller voxels.
constexpr float kLeastSpacing = 1.5e-5f;

/// Which 8^3 bricks of a lattice have storage. Bricks are OpenVDB leaves: brick b owns rows
/// [b * 512, (b + 1) * 512), and within a brick the row of local vertex (x, y, z) is x * 64 + y * 8 + z,
/// OpenVDB's leaf order. Brick 0 is the background brick: it stands for everything that is absent, holds
/// the background values and is never updated, so a gather needs no branch.
///
/// The table has a ring of one absent brick on every side; a position outside the lattice, clamped into the
/// ring, reads the background: outside the box is empty.
struct Topology {
  Lattice lattice;
  Int3 dims{};                      ///< bricks per axis, ring included
  std::vector<std::int32_t> table;  ///< [dims.x * dims.y * dims.z] brick number, z fastest; 0 = absent
  std::vector<Int3> bricks;  ///< [brick_count() + 1] brick coordinate (vertex = 8 * coordinate), [0] unused

  int brick_count() const { return int(bricks.size()) - 1; }
  std::size_t rows() const { return bricks.size() * std::size_t(kBrickRows); }
  std::size_t slot(Int3 brick) const {
    return (std::size_t(brick.x + 1) * dims.y + (brick.y + 1)) * dims.z + (brick.z + 1);
  }
  /// Vertex of a brick's row.
  Int3 vertex(int brick, int row) const {
    const Int3 b = bricks[brick];
    return {b.x * kBrick + (row >> 6), b.y * kBrick + (row >> 3 & 7), b.z * kBrick + (row & 7)};
  }
  /// Position of a brick's row, scene units.
  Vec3 position(int brick, int row) const { return lattice.position(vertex(brick, row)); }
  /// Brick number at a brick coordinate; coordinates in the ring are absent. @pre -1 <= coordinate <= dims
  /// - 2.
  std::int32_t brick_at(Int3 brick) const { return table[slot(brick)]; }
};

using TopologyPtr = std::shared_ptr<const Topology>;

/// Freezes a list of brick coordinates (each within the lattice, no duplicates) into a topology.
/// Bricks are numbered in the order of their coordinates, x slowest, so the numbering depends only on the
/// set.
TopologyPtr make_topology(const Lattice& lattice, std::vector<Int3> bricks);
/// Every brick of the lattice.
TopologyPtr make_dense_topology(const Lattice& lattice);

/// Floats a row of `columns` takes: a whole number of vector registers.
constexpr int padded_width(int columns) { return (columns + 7) / 8 * 8; }

/// One value array over a topology: rows of `width` floats (a multiple of 8: one or more vector registers).
struct Channels {
  TopologyPtr topology;
  int width = 0;
  AlignedVector<float> values;  ///< [topology->rows() * width]

  float* row(std::size_t r) { return values.data() + r * width; }
  const float* row(std::size_t r) const { return values.data() + r * width; }
};

/// Every row set to `background` ([width] floats).
Channels make_channels(TopologyPtr topology, int width, const float* background);

/// Numbers of the bricks that have a row above `raw` in the first column or lie next to one, ascending: every
/// cell with such a corner has all its corners in them.
std::vector<std::int32_t> bricks_above(const Channels& channels, float raw);
/// The topology of some of the bricks. @param bricks  numbers, ascending
TopologyPtr keep_bricks(const Topology& topology, const std::vector<std::int32_t>& bricks);
/// Leaves of rows ([bricks + 1] * 512 * width) those of the background and of some bricks, in place; what
/// they took is theirs until shrink_to_fit.
void keep_rows(const std::vector<std::int32_t>& bricks, int width, AlignedVector<float>& rows);

}  // namespace splinevox
