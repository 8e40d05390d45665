// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace splinevox {

/// A splat is a Gaussian of opacity o that hides the share o g of what is behind it, g = exp(-r^2 / 2) with r
/// the distance to its centre on the picture, in standard deviations. Its optical depth there is -log(1 - o
/// g).

inline constexpr double kMostOpacity = 0.99;        ///< renderers of splats draw no more
inline constexpr double kLeastOpacity = 1 / 255.0;  ///< and leave out what is less

/// The dilogarithm Li2(x) = sum_n x^n / n^2 for x in [0, 1]. It is the integral of -log(1 - x g) over the
/// plane, divided by 2 pi.
inline double dilogarithm(double x) {
  constexpr double kAtOne = std::numbers::pi * std::numbers::pi / 6;
  if (x > 0.5) return x >= 1 ? kAtOne : kAtOne - std::log(x) * std::log1p(-x) - dilogarithm(1 - x);
  double sum = 0, power = x;
  for (int n = 1; n <= 60 && power > 1e-18; ++n) {
    sum += power / (double(n) * n);
    power *= x;
  }
  return sum;
}

/// Its inverse. @param value  at most kMostOpacity is returned for what is larger
inline double inverse_dilogarithm(double value) {
  double low = 0, high = kMostOpacity;
  if (value <= 0) return 0;
  if (value >= dilogarithm(high)) return high;
  double x = std::min(value, high);
  for (int i = 0; i < 60; ++i) {
    const double error = dilogarithm(x) - value;
    (error > 0 ? high : low) = x;
    const double slope = -std::log1p(-x) / x;
    const double next = x - error / slope;
    const double kept = next > low && next < high ? next : (low + high) / 2;
    if (std::abs(kept - x) < 1e-14) break;
    x = kept;
  }
  return x;
}

/// Optical depth of a splat, integrated over the plane that it is seen in: what it hides in all. Length^2.
/// @param first,second  its standard deviations on that plane
inline double splat_cross_section(double opacity, double first, double second) {
  return 2 * std::numbers::pi * first * second * dilogarithm(opacity);
}

/// The opacity of a round splat that stands for a voxel: one splat in every voxel of a medium of `density`
/// hides as much as the medium, on the mean over the places of a ray and for all its directions. Renderers
/// draw kMostOpacity at most, so denser media come out thinner.
/// @param density  1 / length @param spacing  of the voxels @param size  standard deviation of the splats
inline double voxel_splat_opacity(double density, double spacing, double size) {
  const double cross_section = density * spacing * spacing * spacing;
  return inverse_dilogarithm(cross_section / splat_cross_section(1, size, size) * dilogarithm(1));
}

/// Sign of a harmonic of math/sh.hpp in files of splats, whose basis has the Condon-Shortley phase.
/// @param index  l (l + 1) + m
constexpr double splat_harmonic_sign(int index) {
  const int band = index == 0 ? 0 : index < 4 ? 1 : index < 9 ? 2 : 3;
  return (index - band * (band + 1)) % 2 == 0 ? 1 : -1;
}

}  // namespace splinevox
