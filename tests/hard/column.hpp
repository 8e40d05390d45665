// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/backward.hpp"

namespace splinevox::test {

/// A still field that varies along x only, and a ray along x whose sample i meets vertex i exactly: what the
/// kernel makes of a list of raw values, without any error of position or interpolation.
template <class Real>
struct RayColumn {
  static constexpr int kWidth = RayKernel<Real, -1>::kWidth;
  TopologyPtr topology;
  std::vector<Real> rows;
  FieldView<Real> field;
  FrameView<Real> frame;
  RayInput<Real> ray;

  explicit RayColumn(int samples)
      : topology(make_dense_topology({{0, 0, 0}, 1, {samples + 1, 2, 2}})), rows(topology->rows() * kWidth) {
    field.radiance = BrickView<Real>(*topology);
    field.radiance_rows = rows.data();
    field.density_scale = 1;
    field.density_shift = 0;
    field.step = 1;
    ray.origin = {0, 0, 0};
    ray.direction = {1, 0, 0};
    ray.count = samples;
    ray.background = {Real(0.25), Real(0.5), Real(0.75)};
  }
  Real* row(int x) {
    return rows.data() +
           (std::size_t(topology->brick_at({x >> 3, 0, 0})) * kBrickRows + std::size_t(x & 7) * 64) * kWidth;
  }
  /// Raw density and colour at vertex x. The ray runs along an edge, so only this row has weight.
  void set(int x, Real density, Real r, Real g, Real b) {
    Real* to = row(x);
    to[0] = density;
    to[1] = r;
    to[2] = g;
    to[3] = b;
  }
};

}  // namespace splinevox::test
