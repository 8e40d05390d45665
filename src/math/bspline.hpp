// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>

#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Uniform B-spline weights: degree min(3, K - 1), knots evenly spaced, [0, 1] cut into K - degree spans.
/// Local: at most four weights are not zero. The knots go on beyond both ends, so the first and the last time
/// share their points with their neighbours and are as well determined as the rest: with knots clamped to the
/// ends, the end points had only the last frames to learn from, and those times came out worst
/// (docs/experiments.md).
///
/// Source: Cox-de Boor recursion on the non-zero weights of one span; every intermediate is a convex
/// combination.
/// @param t  time in [0, 1]; the caller clamps.
template <class T>
constexpr BasisWeights<T> bspline_weights(int points, T t, int degree = 3) {
  degree = std::min(degree, points - 1);
  const int spans = points - degree;
  const auto knot = [&](int i) { return T(i - degree) / T(spans); };
  int span = degree;
  while (span < points - 1 && !(t < knot(span + 1))) ++span;
  // b[j] is the weight of point span - degree + j.
  std::array<T, 4> b{};
  b[0] = T(1);
  for (int d = 1; d <= degree; ++d) {
    T carried = T(0);
    for (int j = 0; j < d; ++j) {
      const T lo = knot(span + 1 - d + j), hi = knot(span + 1 + j);
      const T share = b[j] / (hi - lo);
      b[j] = carried + (hi - t) * share;
      carried = (t - lo) * share;
    }
    b[d] = carried;
  }
  BasisWeights<T> w{};
  for (int j = 0; j <= degree; ++j) w[span - degree + j] = b[j];
  return w;
}

/// d w_k / d t of bspline_weights: degree / knot distance times differences of the weights one degree lower
/// on the same knots. Sums to 0.
template <class T>
constexpr BasisWeights<T> bspline_weights_dt(int points, T t) {
  const int degree = std::min(3, points - 1);
  const int spans = points - degree;
  const auto knot = [&](int i) { return T(i - degree) / T(spans); };
  // The curve's derivative has points - 1 control points q_k = degree (p_{k+1} - p_k) / (knot[k+degree+1] -
  // knot[k+1]) on the knots without their first and last, which is again a uniform B-spline, one degree
  // lower.
  const BasisWeights<T> lower = bspline_weights(points - 1, t, degree - 1);
  BasisWeights<T> d{};
  for (int k = 0; k < points - 1; ++k) {
    const T slope = T(degree) / (knot(k + degree + 1) - knot(k + 1)) * lower[k];
    d[k] = d[k] - slope;
    d[k + 1] = d[k + 1] + slope;
  }
  return d;
}

/// Exact insertion of a knot in the middle of every span of one component of a uniform cubic B-spline, K ->
/// 2K - 3 control points: the curve stays the same (convex combinations).
///
/// Source: Lane and Riesenfeld, subdivision of uniform B-splines. `out` may not alias `in`. @pre points >= 4
///
///   q_2i = (p_i + p_{i+1}) / 2,  q_{2i+1} = (p_i + 6 p_{i+1} + p_{i+2}) / 8
template <class T>
constexpr void halve_bspline(int points, const T* in, T* out) {
  for (int i = 0; i + 1 < points; ++i) out[2 * i] = (in[i] + in[i + 1]) / 2;
  for (int i = 0; i + 2 < points; ++i) out[2 * i + 1] = (in[i] + 6 * in[i + 1] + in[i + 2]) / 8;
}

}  // namespace splinevox
