// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <vector>

#include "math/depth_loss.hpp"
#include "render/ray_kernel.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox::test {

inline constexpr double kSpacing = 0.25, kStep = 0.11;

/// A scene small enough to differentiate with respect to every number: lattices of a few bricks with a hole,
/// random values, a handful of rays.
template <int Sh>
struct TinyScene {
  static constexpr int kWidth = RayKernel<double, Sh>::kWidth;
  TopologyPtr radiance, motion;
  std::vector<double> rows, slice, behind;  ///< behind: colours behind the rays, [rays * 3]
  FieldView<double> field;
  FrameView<double> frame;
  std::vector<RayInput<double>> rays;
  std::vector<Vec3d> targets, probes;
  double rest = 0;  ///< of every ray
  std::vector<DepthTarget<double>> depths;
  double depth_weight = 0;
  double prior = 0;  ///< weight of transmittance_prior

  explicit TinyScene(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const Lattice fine{{-1, -1, -1}, float(kSpacing), {12, 9, 9}},
        coarse{{-1, -1, -1}, float(2 * kSpacing), {9, 5, 5}};
    radiance = make_topology(fine, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});  // others are absent
    motion = make_dense_topology(coarse);
    rows.resize(radiance->rows() * kWidth);
    slice.resize(motion->rows() * kSliceWidth);
    // Numbers that float holds too, so that both precisions differentiate the same scene.
    for (double& v : rows) v = float(1.5 * uniform(random));
    for (double& v : slice) v = float(0.3 * uniform(random));
    for (int i = 0; i < kBrickRows; ++i)
      for (int c = 0; c < kWidth; ++c) rows[i * kWidth + c] = c == 0 ? -10 : 0;
    for (int i = 0; i < kBrickRows * kSliceWidth; ++i) slice[i] = 0;
    field.radiance = BrickView<double>(*radiance);
    field.radiance_rows = rows.data();
    field.motion = BrickView<double>(*motion);
    field.moving = field.rigidity = true;
    field.rigidity_offset = 0.4;
    field.density_scale = 3;
    field.density_shift = -0.5;
    field.step = kStep;
    frame.slice = slice.data();
    for (int i = 0; i < 6; ++i) {
      RayInput<double> ray;
      ray.origin = {-1 + 0.05 * uniform(random), 0.4 * uniform(random), 0.4 * uniform(random)};
      ray.direction = normalize(Vec3d{1, 0.4 * uniform(random), 0.4 * uniform(random)});
      ray.count = 16 + i;
      ray.background = {0.3, 0.6, 0.9};
      rays.push_back(ray);
      targets.push_back({0.5 + 0.5 * uniform(random), 0.5, 0.2});
      if (i == 5) {
        rays.back().background.x = 3;
        targets.back().x = targets.back().z = -1;  // 1 or more
      }                                            // clipped: brighter in red, darker in blue
      for (int c = 0; c < 3; ++c) behind.push_back(rays.back().background[c]);
      probes.push_back({1, i % 2 ? -1.0 : 1.0, 1});
      depths.push_back({float(0.2 + 0.3 * i), i == 2 ? 0.0 : 0.25});  // one unknown, one behind the box
    }
  }

  /// `field` in another scalar, over rows that the caller keeps.
  template <class Real>
  FieldView<Real> field_in(const std::vector<Real>& its_rows) const {
    FieldView<Real> out;
    out.radiance = BrickView<Real>(*radiance);
    out.motion = BrickView<Real>(*motion);
    out.radiance_rows = its_rows.data();
    out.moving = field.moving;
    out.rigidity = field.rigidity;
    out.rigidity_offset = Real(field.rigidity_offset);
    out.density_scale = Real(field.density_scale);
    out.density_shift = Real(field.density_shift);
    out.step = Real(field.step);
    return out;
  }
};

}  // namespace splinevox::test
