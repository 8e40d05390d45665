// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/math/basis.hpp"

namespace splinevox {

/// A Bezier curve feels every point everywhere: more of them is a B-spline's work.
inline constexpr int kMaxBezierPoints = 20;

/// Bernstein weights w_k(t) of K control points (degree K - 1), so that a curve is sum_k w_k(t) p_k.
///
/// Source: Spline-NeRF, Eq. 2 and 3, by the triangle of De Casteljau applied to the weights, one degree at a
/// time: every intermediate stays in [0, 1]. Evaluated once per frame in double and rounded, a curve is then
/// one dot product, which is more accurate and far cheaper than De Casteljau per voxel (numerics H1).
///
/// @param t  time in [0, 1]; the caller clamps. t = 0 gives (1, 0, .., 0), t = 1 gives (0, .., 0, 1),
/// exactly.
/// @note  The paper prints Eq. 3 with index i - 1, which runs the curve backwards; we use i + 1 as the
/// released code.
template <class T>
constexpr BasisWeights<T> bernstein_weights(int points, T t) {
  BasisWeights<T> w{};
  w[0] = T(1);
  for (int degree = 1; degree < points; ++degree) {
    for (int k = degree; k > 0; --k) w[k] = (T(1) - t) * w[k] + t * w[k - 1];
    w[0] = (T(1) - t) * w[0];
  }
  return w;
}

/// d w_k / d t: differences of the weights one degree lower, times the degree K - 1 (not the number of
/// points). Sums to 0.
template <class T>
constexpr BasisWeights<T> bernstein_weights_dt(int points, T t) {
  const BasisWeights<T> lower = bernstein_weights(points - 1, t);
  BasisWeights<T> d{};
  for (int k = 0; k < points - 1; ++k) {
    d[k] = d[k] - T(points - 1) * lower[k];
    d[k + 1] = d[k + 1] + T(points - 1) * lower[k];
  }
  return d;
}

/// Exact degree elevation of one Bezier curve component, K -> K + 1 control points: the curve stays the same
/// (a convex combination, hence benign: numerics H3). `out` may not alias `in`.
///
///   q_0 = p_0,  q_i = (i / K) p_{i-1} + (1 - i / K) p_i,  q_K = p_{K-1}
template <class T>
constexpr void elevate_bezier(int points, const T* in, T* out) {
  out[0] = in[0];
  for (int i = 1; i < points; ++i) {
    const T a = T(i) / T(points);
    out[i] = a * in[i - 1] + (T(1) - a) * in[i];
  }
  out[points] = in[points - 1];
}

}  // namespace splinevox
