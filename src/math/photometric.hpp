// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A target is what a picture says of a colour, per channel: v >= 0 is that value; -v with v > 0 is "v or
/// more".
///
/// Most pictures end at 1, so where they show 1 there was 1 or more. Behind a camera's gain g that is 1/g or
/// more (math/exposure.hpp), and what is not cut off may be beyond 1.
template <class T>
SPLINEVOX_HD inline T at_least(T value) {
  return -value;
}
template <class T>
SPLINEVOX_HD inline bool is_bound(T target) {
  return target < T(0);
}
/// The colour that a target names, as a value or as a bound.
template <class T>
SPLINEVOX_HD inline Vec3T<T> colour_of(const Vec3T<T>& target) {
  Vec3T<T> out = target;
  for (int c = 0; c < 3; ++c)
    if (is_bound(target[c])) out[c] = -target[c];
  return out;
}

/// How far a colour is from its target, per channel; the photometric loss is its square, and twice it the
/// gradient.
///
/// A colour brighter than a bound is no error. Pulled back to 1, a lit floor would have to get darker exactly
/// where a picture clips it, which no light does (docs/experiments.md). Beyond the kink the derivative is 0.
///
/// Not in the paper, whose loss (Eq. 8) takes clipped values for true ones.
template <class T>
SPLINEVOX_HD inline Vec3T<T> photometric_error(const Vec3T<T>& rgb, const Vec3T<T>& target) {
  Vec3T<T> error = rgb - colour_of(target);
  for (int c = 0; c < 3; ++c)
    if (is_bound(target[c]) && error[c] > T(0)) error[c] = T(0);
  return error;
}

/// Derivative of weight times the squared error by the colour.
template <class T>
SPLINEVOX_HD inline Vec3T<T> photometric_gradient(const Vec3T<T>& error, T weight) {
  return T(2) * (weight * error);
}
template <class T>
SPLINEVOX_HD inline Vec3T<T> photometric_gradient(const Vec3T<T>& rgb, const Vec3T<T>& target, T weight) {
  return photometric_gradient(photometric_error(rgb, target), weight);
}

}  // namespace splinevox
