// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/simd.hpp"
#include "field/lattice/brick_view.hpp"

namespace splinevox {

/// One position resolved: the eight rows around it and where it lies between them. The plain path of
/// everything that is not the ray kernel, which does the same for many samples at once.
struct Located {
  Vec3 fraction;
  CellRows rows;
};

inline Located locate(const BrickView<float>& view, Vec3 x) {
  Located out;
  int base[3];
  for (int a = 0; a < 3; ++a) {
    const float u = view.coordinate(x[a], a);
    base[a] = int(u);
    out.fraction[a] = u - float(base[a]);
  }
  out.rows = view.rows(view.cell(base[0], base[1], base[2]));
  return out;
}

/// Interpolated register of columns [offset, offset + lanes) of rows of `width` floats.
template <class V>
V interpolate(const Located& at, const float* values, int width, int offset) {
  float w[kCorners];
  trilinear_weights(at.fraction, w);
  V sum{};
  for (int c = 0; c < kCorners; ++c)
    sum += w[c] * load<V>(values + std::size_t(at.rows.row[c]) * width + offset);
  return sum;
}

}  // namespace splinevox
