// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// How far a colour is from what a picture says of it, per channel; the photometric loss is its square, and
/// twice it the gradient.
///
/// Pictures end at 1: a target of 1 says "1 or more", and a brighter colour is no error. Pulled back to 1, a
/// lit floor would have to get darker exactly where a picture clips it, which no light does
/// (docs/experiments.md). Beyond the kink the derivative is 0.
///
/// Not in the paper, whose loss (Eq. 8) takes clipped values for true ones.
template <class T>
SPLINEVOX_HD inline Vec3T<T> photometric_error(const Vec3T<T>& rgb, const Vec3T<T>& target) {
  Vec3T<T> error = rgb - target;
  for (int c = 0; c < 3; ++c)
    if (target[c] >= T(1) && error[c] > T(0)) error[c] = T(0);
  return error;
}

}  // namespace splinevox
