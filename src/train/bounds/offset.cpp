// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/offset.hpp"

#include "core/parallel.hpp"
#include "field/lattice/locate.hpp"

namespace splinevox {
namespace {

constexpr int kWidth = padded_width(3);
constexpr int kSweeps = 100;  ///< three times the cells along an edge: enough for smoothness, and nothing is
                              ///< visible far from where the offset is known
constexpr int kIterations = 6;

/// Replaces what is not known by the mean of its neighbours, in as many sweeps.
std::vector<Vec3> filled(const BitGrid& cells, std::vector<Vec3> values) {
  std::vector<Vec3> next = values;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    parallel_for(cells.size.x, [&](int x) {
      Int3 c{x, 0, 0};
      for (c.y = 0; c.y < cells.size.y; ++c.y)
        for (c.z = 0; c.z < cells.size.z; ++c.z) {
          if (cells.test(cells.index(c))) continue;
          Vec3 sum{};
          int count = 0;
          for (int a = 0; a < 3; ++a)
            for (const int step : {-1, 1}) {
              Int3 at = c;
              at[a] += step;
              if (at[a] >= 0 && at[a] < cells.size[a]) {
                sum += values[cells.index(at)];
                ++count;
              }
            }
          if (count > 0) next[cells.index(c)] = (1.0f / float(count)) * sum;
        }
    });
    std::swap(values, next);
  }
  return values;
}

}  // namespace

Offset::Offset(const BitGrid& cells, const std::vector<Vec3>& known) {
  const float half = 0.5f * cells.cell;
  const std::vector<float> zero(kWidth, 0.0f);
  values_ = make_channels(make_dense_topology({cells.origin + Vec3{half, half, half}, cells.cell,
                                               max(cells.size, Int3{2, 2, 2})}),
                          kWidth, zero.data());
  const std::vector<Vec3> all = filled(cells, known);
  const Topology& t = *values_.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Int3 c = t.vertex(b, i);
      if (c.x >= cells.size.x || c.y >= cells.size.y || c.z >= cells.size.z) continue;
      for (int a = 0; a < 3; ++a) values_.row(std::size_t(b) * kBrickRows + i)[a] = all[cells.index(c)][a];
    }
  view_ = BrickView<float>(t);
  centers_ = {cells.center({0, 0, 0}), cells.center(cells.size - Int3{1, 1, 1})};
}

Vec3 Offset::at(Vec3 x) const {
  const Vec3 inside = max(centers_.lo, min(centers_.hi, x));
  const auto v = interpolate<Simd<float>::Four>(locate(view_, inside), values_.values.data(), kWidth, 0);
  return {v[0], v[1], v[2]};
}

Vec3 Offset::undo(Vec3 z) const {
  Vec3 y = z;
  for (int i = 0; i < kIterations; ++i) y = z - at(y);
  return y;
}

}  // namespace splinevox
