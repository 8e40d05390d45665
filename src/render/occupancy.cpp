// SPDX-License-Identifier: Apache-2.0
#include "splinevox/render/occupancy.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "splinevox/core/parallel.hpp"
#include "splinevox/core/simd.hpp"
#include "splinevox/math/activation.hpp"

namespace splinevox {
namespace {

/// ORs each cell with its two neighbours along one axis.
BitGrid dilate_axis(const BitGrid& in, int axis) {
  BitGrid out = in;
  const std::size_t stride = axis == 0 ? std::size_t(in.size.y) * in.size.z : axis == 1 ? std::size_t(in.size.z) : 1;
  Int3 c;
  for (c.x = 0; c.x < in.size.x; ++c.x)
    for (c.y = 0; c.y < in.size.y; ++c.y)
      for (c.z = 0; c.z < in.size.z; ++c.z) {
        const std::size_t i = in.index(c);
        if (!in.test(i)) continue;
        if (c[axis] > 0) out.set(i - stride);
        if (c[axis] + 1 < in.size[axis]) out.set(i + stride);
      }
  return out;
}

}  // namespace

BitGrid::BitGrid(const Box& box, int cells_along_longest) : origin(box.lo) {
  const Vec3 extent = box.extent();
  cell = std::max({extent.x, extent.y, extent.z}) / float(cells_along_longest);
  for (int a = 0; a < 3; ++a) size[a] = std::max(1, int(std::ceil(extent[a] / cell - 1e-3f)));
  bits.assign((cells() + 31) / 32, 0);
}

Int3 BitGrid::cell_of(Vec3 x) const {
  Int3 c;
  for (int a = 0; a < 3; ++a) c[a] = std::clamp(int(std::floor((x[a] - origin[a]) / cell)), 0, size[a] - 1);
  return c;
}

std::size_t BitGrid::count() const {
  std::size_t n = 0;
  for (const std::uint32_t word : bits) n += std::popcount(word);
  return n;
}

BitGrid dilate(const BitGrid& grid) { return dilate_axis(dilate_axis(dilate_axis(grid, 0), 1), 2); }

BitGrid canonical_occupancy(const VoxelModel& model, int cells, float alpha, float step) {
  const RadianceField& field = model.radiance;
  const Topology& topology = *field.raw.topology;
  const Lattice& lattice = topology.lattice;
  BitGrid grid(model.box, cells);
  // alpha >= a  <=>  softplus(raw + shift) >= -log(1 - a) / (scale step)  <=>  raw >= log(expm1(that)) - shift.
  const double depth = -std::log1p(-double(alpha)) / (double(field.activation.scale) * step);
  const float threshold = float(std::log(std::expm1(depth)) - field.activation.shift);
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      if (!(field.raw.row(std::size_t(b) * kBrickRows + i)[0] >= threshold)) continue;
      const Int3 brick = topology.bricks[b];
      const Vec3 x = lattice.position({brick.x * kBrick + (i >> 6), brick.y * kBrick + (i >> 3 & 7), brick.z * kBrick + (i & 7)});
      const Vec3 reach{lattice.spacing, lattice.spacing, lattice.spacing};
      const Int3 lo = grid.cell_of(x - reach), hi = grid.cell_of(x + reach);
      for (int cx = lo.x; cx <= hi.x; ++cx)
        for (int cy = lo.y; cy <= hi.y; ++cy)
          for (int cz = lo.z; cz <= hi.z; ++cz) grid.set(grid.index({cx, cy, cz}));
    }
  return dilate(grid);
}

BitGrid frame_occupancy(const VoxelModel& model, const MotionSlice& slice, const BitGrid& canonical, const BitGrid* within) {
  using Four = Simd<float>::Four;
  if (!slice.topology) return canonical;
  BitGrid out = canonical;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  const BrickView<float> view(*slice.topology);
  Int3 c;
  std::size_t i = 0;
  for (c.x = 0; c.x < out.size.x; ++c.x)
    for (c.y = 0; c.y < out.size.y; ++c.y)
      for (c.z = 0; c.z < out.size.z; ++c.z, ++i) {
        if (within && !within->test(i)) continue;
        const Vec3 x = out.center(c);
        Vec3 f;
        int base[3];
        for (int a = 0; a < 3; ++a) {
          const float u = view.coordinate(x[a], a);
          base[a] = int(u);
          f[a] = u - float(base[a]);
        }
        const CellRows rows = view.rows(view.cell(base[0], base[1], base[2]));
        float w[kCorners];
        trilinear_weights(f, w);
        Four m{};
        for (int k = 0; k < kCorners; ++k) m += w[k] * load<Four>(slice.values.data() + std::size_t(rows.row[k]) * kSliceWidth);
        const float r = model.motion.rigidity ? sigmoid(m[3] + model.motion.rigidity_offset).value : 1.0f;
        if (canonical.test(canonical.index(canonical.cell_of(x + r * Vec3{m[0], m[1], m[2]})))) out.set(i);
      }
  return out;
}

}  // namespace splinevox
