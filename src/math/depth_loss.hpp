// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "math/activation.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// How far away what a ray shows is, from its sample 0 on.
template <class T>
struct DepthTarget {
  T distance = 0;  ///< scene units; may be beyond the last sample: nothing is known to be before that
  T scale = 0;     ///< 1 / distance from the camera, 1 / scene unit; 0: nothing is known
};

/// From this share of the distance on an error counts as the error does, and no longer as its square.
inline constexpr double kDepthWidth = 0.05;

/// Robust error of a distance, relative to that from the camera, so that no unit matters: Charbonnier's
/// penalty, about x^2 / 2 near 0 and kDepthWidth |x| beyond, with its derivative by the distance. A depth map
/// has edges where a picture's pixels mix what is near and far, and may be wrong in places.
/// Source: Charbonnier et al., Two deterministic half-quadratic regularization algorithms, 1994.
/// @param distance  the ray's expected one, from sample 0 on
template <class T>
SPLINEVOX_INLINE Activated<T> depth_error(T distance, const DepthTarget<T>& target) {
  using std::sqrt;
  const T width = T(kDepthWidth), x = target.scale * (distance - target.distance) / width,
          root = sqrt(T(1) + x * x);
  return {width * width * (root - T(1)), width * target.scale * x / root};
}

}  // namespace splinevox
