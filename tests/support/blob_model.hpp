// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>

#include "splinevox/field/model.hpp"

namespace splinevox::test {

/// Motion of the blob as a function of the observed position; the curve is a Bezier with its first point
/// pinned.
struct BlobMotion {
  bool moves = true;
  int points = 3;
  Vec3 shift{-0.5f, 0.1f,
             0.2f};       ///< displacement to canonical at t = 1, scene units: the blob moves at -shift
  float twist = 0;        ///< further displacement, twist * t * (y, -x, 0) and a stretch along z: not uniform
  bool rigidity = false;  ///< store a rigidity that varies in space
  float light = 0;        ///< raw light at t = 1 is this times y; 0: no light
};

inline std::vector<Int3> all_bricks(const Lattice& lattice) {
  std::vector<Int3> bricks;
  for (int x = 0; x * kBrick < lattice.size.x; ++x)
    for (int y = 0; y * kBrick < lattice.size.y; ++y)
      for (int z = 0; z * kBrick < lattice.size.z; ++z) bricks.push_back({x, y, z});
  return bricks;
}

/// A coloured ball with soft edges, radius 0.35 about (0.1, -0.05, 0), in a box that is no cube. Bricks that
/// it does not reach are absent.
inline VoxelModel blob_model(int cells, const BlobMotion& motion = {}, int sh_order = 1, float density = 40) {
  VoxelModel m;
  m.box = {{-1, -0.8f, -0.9f}, {1.1f, 0.9f, 0.7f}};
  m.background.color = {1, 1, 1};
  m.time_map = {0.25, 1.5};
  const Lattice lattice = make_lattice(m.box, cells);
  m.step = 0.5f * lattice.spacing;
  m.radiance.activation = {density, -4};
  m.radiance.sh_order = sh_order;
  const Vec3 centre{0.1f, -0.05f, 0};
  const float radius = 0.35f, softness = 0.03f;
  const int width = padded_width(4 + m.radiance.sh_count());
  std::vector<float> background(std::size_t(width), 0.0f);
  background[0] = -14;
  std::vector<Int3> bricks;
  for (const Int3& b : all_bricks(lattice)) {
    const Vec3 middle = lattice.position(kBrick * b) + 3.5f * lattice.spacing * Vec3{1, 1, 1};
    if (length(middle - centre) < radius + 7 * lattice.spacing + 5 * softness) bricks.push_back(b);
  }
  m.radiance.raw = make_channels(make_topology(lattice, bricks), width, background.data());
  const Topology& t = *m.radiance.raw.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(b, i);
      const Vec3 d = x - centre;
      float* row = m.radiance.raw.row(std::size_t(b) * kBrickRows + i);
      row[0] = std::max(-14.0f, std::min(6.0f, (radius - length(d)) / softness));
      row[1] = 6 * d.x;
      row[2] = 1 - 5 * d.y;
      row[3] = 4 * std::sin(9 * d.z);
      for (int j = 0; j < m.radiance.sh_count(); ++j) row[4 + j] = 0.6f * std::cos(float(j) + 5 * d.x);
    }
  if (!motion.moves) return m;

  m.motion.basis = BasisKind::bezier;
  m.motion.points = motion.points;
  m.motion.rigidity = motion.rigidity;
  m.motion.light = motion.light != 0;
  m.motion.rigidity_offset = 0.25f;
  const Lattice coarse = make_lattice(m.box, std::max(4, cells / 4));
  const int stride = m.motion.stride(), columns = m.motion.width();
  const std::vector<float> zero(std::size_t(columns), 0.0f);
  m.motion.levels.push_back(make_channels(make_dense_topology(coarse), columns, zero.data()));
  Channels& level = m.motion.levels[0];
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = level.topology->position(b, i);
      const Vec3 end = motion.shift + motion.twist * Vec3{x.y, -x.x, 0.3f * x.z};
      float* row = level.row(std::size_t(b) * kBrickRows + i);
      // Control points on a straight line: uniform motion in time.
      for (int k = 1; k < motion.points; ++k) {
        const float share = float(k) / float(motion.points - 1);
        for (int a = 0; a < 3; ++a) row[stride * (k - 1) + a] = end[a] * share;
        if (m.motion.light) row[stride * (k - 1) + 3] = motion.light * x.y * share;
      }
      if (motion.rigidity) row[m.motion.rigidity_column()] = 3 + x.x;
    }
  return m;
}

/// The same model with every stored number replaced by noise, for tests about bits.
inline VoxelModel noisy_model(unsigned seed, int points, FirstPoint first, BasisKind basis, int sh_order,
                              bool rigidity, bool light = false, bool presence = false) {
  VoxelModel m = blob_model(24, {true, points, {}, 0, rigidity}, sh_order);
  m.motion.basis = basis;
  m.motion.first_point = first;
  m.motion.light = light;
  m.motion.presence = presence;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const std::vector<float> zero(std::size_t(m.motion.width()), 0.0f);
  m.motion.levels[0] = make_channels(m.motion.levels[0].topology, m.motion.width(), zero.data());
  const int used = m.motion.rigidity_column() + (rigidity ? 1 : 0), shown = 4 + m.radiance.sh_count();
  for (std::size_t r = kBrickRows; r < m.radiance.raw.topology->rows(); ++r)
    for (int c = 0; c < shown; ++c) m.radiance.raw.row(r)[c] = normal(random);
  for (std::size_t r = kBrickRows; r < m.motion.levels[0].topology->rows(); ++r)
    for (int c = 0; c < used; ++c) m.motion.levels[0].row(r)[c] = 0.1f * normal(random);
  return m;
}

}  // namespace splinevox::test
