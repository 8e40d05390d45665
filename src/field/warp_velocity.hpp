// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/velocity.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {

/// What moves where the warp was sampled, scene units per unit of model time.
inline MaterialVelocity<double> material_velocity(const FrameSampler::Warp& w) {
  const Vec3d gradient[3] = {cast<double>(w.gradient[0]), cast<double>(w.gradient[1]),
                             cast<double>(w.gradient[2])};
  return material_velocity(gradient, cast<double>(w.velocity_to_canonical));
}

}  // namespace splinevox
