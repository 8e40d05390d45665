// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"
#include "math/sh.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Colour in a direction, sigmoid(sum_j raw_j Y_j(direction)) per channel, and its slope by that sum.
template <class T>
struct BackgroundColor {
  Vec3T<T> value, slope;
};

/// @param raw  [(order + 1)^2]. @param direction  unit length
template <class T>
BackgroundColor<T> background_color(int order, const Vec3T<T>* raw, const Vec3T<T>& direction) {
  T y[kMaxShCount] = {};
  sh_basis(order, direction, y);
  Vec3T<T> sum{};
  for (int j = 0; j < (order + 1) * (order + 1); ++j) sum += y[j] * raw[j];
  const Activated<T> r = sigmoid(sum.x), g = sigmoid(sum.y), b = sigmoid(sum.z);
  return {{r.value, g.value, b.value}, {r.slope, g.slope, b.slope}};
}

/// Adjoint of its value: d_raw += the gradient of the harmonics, in a type of its own to add up many rays in.
/// @param slope  as background_color gave it. @param d_color  gradient of the colour
template <class T, class Sum>
void background_color_vjp(int order, const Vec3T<T>& direction, const Vec3T<T>& slope,
                          const Vec3T<T>& d_color, Vec3T<Sum>* d_raw) {
  T y[kMaxShCount] = {};
  sh_basis(order, direction, y);
  const Vec3T<Sum> d_sum = cast<Sum>(mul(d_color, slope));
  for (int j = 0; j < (order + 1) * (order + 1); ++j) d_raw[j] += Sum(y[j]) * d_sum;
}

}  // namespace splinevox
