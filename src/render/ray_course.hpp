// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <type_traits>

#include "render/views.hpp"

namespace splinevox {

/// The coordinates of a ray's samples in a lattice, u_i = (coarse + i coarse_step) + (fine + i fine_step).
/// A coordinate of some hundred vertices leaves a float few digits for its fraction, and what rounding
/// moves there is multiplied by the slopes of density and displacement: it was nine tenths of the error of
/// a gradient (numerics, "Float against double"). The coarse part is a multiple of 2^-14, of which a float
/// holds every sum up to 1024 exactly; the fine part is small.
template <class Real>
struct RayCourse {
  Vec3T<Real> coarse, fine, coarse_step, fine_step;
  RayCourse() = default;
  RayCourse(const BrickView<Real>& view, const RayInput<Real>& ray, Real step) {
    for (int a = 0; a < 3; ++a)
      if constexpr (std::is_same_v<Real, float>) {
        const double inv = view.inv_spacing;
        split((double(ray.origin[a]) - view.origin[a]) * inv, coarse[a], fine[a]);
        split(double(step) * ray.direction[a] * inv, coarse_step[a], fine_step[a]);
      } else {
        coarse[a] = (ray.origin[a] - view.origin[a]) * view.inv_spacing;
        coarse_step[a] = step * ray.direction[a] * view.inv_spacing;
      }
  }
  static void split(double u, float& coarse, float& fine) {
    coarse = float(std::rint(u * 0x1p14) * 0x1p-14);
    fine = float(u - double(coarse));
  }
};

}  // namespace splinevox
