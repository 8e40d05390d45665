// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/hd.hpp"

namespace splinevox {

/// What holds the curves of many control points together where pictures do not say otherwise.
struct CurvePrior {
  static constexpr int kScalars = 4;  ///< curves of one number, as the raw light is: no model has more
  float length = 0;                   ///< weight of squared lengths between control points, 1 / scene units^2
  float scalar[kScalars] = {};  ///< weights of squared differences of such numbers between control points
  int lane[kScalars] = {};      ///< where a control point keeps them
  float knots = 0;              ///< weight of jumps at knots that halving brought in, 1 / scene unit
  int spacing = 1;              ///< of the knots that were there before: 2 to the number of halvings
  float softening = 0;  ///< > 0 with knots; jumps much shorter than it pay by their square, scene units

  constexpr bool any() const {
    bool found = length > 0 || (knots > 0 && spacing > 1);
    for (const float weight : scalar) found |= weight > 0;
    return found;
  }
};

/// Keeps a place static whose motion no picture asks for: along stripes, say. It acts on the motion as a
/// whole. On each level of a sum, a fine level would pay for undoing what a coarse one does next to it.
struct StaticPrior {
  float weight = 0;     ///< of the length of a curve, 1 / scene unit
  float softening = 0;  ///< > 0 with weight; curves much shorter than it pay by their square, scene units

  constexpr bool any() const { return weight > 0; }
};

/// weight * |p_k - p_{k-1}|^2 for the steps k in [first, last); adds its gradient.
///
/// @tparam Lanes  3: of a place, 1: of the raw light
/// @param row  the lanes of point k at row[stride * k]; before point 0 comes one that is pinned to zero
template <class T, int Lanes>
SPLINEVOX_HD inline T step_lengths_vjp(const T* row, int stride, int first, int last, T weight, T* gradient) {
  T value = 0;
  for (int k = first; k < last; ++k)
    for (int a = 0; a < Lanes; ++a) {
      const T step = row[stride * k + a] - (k == 0 ? T(0) : row[stride * (k - 1) + a]);
      const T d = T(2) * weight * step;
      value += weight * step * step;
      gradient[stride * k + a] += d;
      if (k > 0) gradient[stride * (k - 1) + a] -= d;
    }
  return value;
}

/// weight * |p_a - 2 p_b + p_c|^2 of a place; adds its gradient.
template <class T>
SPLINEVOX_HD inline T bend_vjp(const T* row, int stride, int a, int b, int c, T weight, T* gradient) {
  T value = 0;
  for (int i = 0; i < 3; ++i) {
    const T bend = row[stride * a + i] - T(2) * row[stride * b + i] + row[stride * c + i];
    const T d = T(2) * weight * bend;
    value += weight * bend * bend;
    gradient[stride * a + i] += d;
    gradient[stride * b + i] -= T(2) * d;
    gradient[stride * c + i] += d;
  }
  return value;
}

/// weight * sum_k |p_{k+1} - p_k|^2 of a place, with |p_0 - 2 p_1 + p_2|^2 for the step at an end that is
/// free; adds its gradient.
///
/// The squared length draws an inner point to the middle of its neighbours. The last point has one neighbour,
/// and would be drawn back to where the curve came from. So an end is asked to go on as the curve did.
///
/// @param row     x, y, z of point k at row[stride * k]
/// @param pinned  the curve starts at a point pinned to zero before the first stored one
template <class T>
SPLINEVOX_HD inline T curve_length_vjp(const T* row, int stride, int stored_points, bool pinned, T weight,
                                       T* gradient) {
  const int n = stored_points;
  if (n < 4) return step_lengths_vjp<T, 3>(row, stride, pinned ? 0 : 1, n, weight, gradient);
  T value = step_lengths_vjp<T, 3>(row, stride, pinned ? 0 : 2, n - 1, weight, gradient);
  if (!pinned) value += bend_vjp(row, stride, 0, 1, 2, weight, gradient);
  return value + bend_vjp(row, stride, n - 1, n - 2, n - 3, weight, gradient);
}

/// weight * (sqrt(S + s^2) - s), S = sum_k |p_{k+1} - p_k|^2 and s the softening; adds its gradient, at most
/// twice as long as the weight however far the curve leads: a curve is static or moves as a whole (group
/// lasso: Yuan and Lin 2006).
///
/// @param row, pinned  as of curve_length_vjp
template <class T>
SPLINEVOX_HD inline T static_curve_vjp(const T* row, int stride, int stored_points, bool pinned, T weight,
                                       T softening, T* gradient) {
  using std::sqrt;
  T squares = 0;
  for (int k = pinned ? 0 : 1; k < stored_points; ++k)
    for (int a = 0; a < 3; ++a) {
      const T step = row[stride * k + a] - (k == 0 ? T(0) : row[stride * (k - 1) + a]);
      squares += step * step;
    }
  const T length = sqrt(squares + softening * softening);
  step_lengths_vjp<T, 3>(row, stride, pinned ? 0 : 1, stored_points, weight / (T(2) * length), gradient);
  return weight * squares / (length + softening);  // sqrt - s as printed cancels
}

/// weight * sum_j (sqrt(|J_j|^2 + s^2) - s) over the knots j of a uniform cubic B-spline that are no multiple
/// of `spacing`, s the softening; adds its gradient.
///
///   J_j = p_{j-1} - 4 p_j + 6 p_{j+1} - 4 p_{j+2} + p_{j+3}
///
/// is the jump of the third derivative there, in units of the cubed distance of two knots: where it is 0 the
/// curve does without the knot. The length and not its square: few knots keep large jumps and the others lose
/// theirs, so the number of control points adapts to each voxel (trend filtering: Kim, Koh, Boyd and
/// Gorinevsky 2009).
///
/// @param row  x, y, z of point k at row[stride * k], none of them pinned
template <class T>
SPLINEVOX_HD inline T knot_jumps_vjp(const T* row, int stride, int points, int spacing, T weight, T softening,
                                     T* gradient) {
  using std::sqrt;
  constexpr float kDifference[5] = {1, -4, 6, -4, 1};
  T value = 0;
  for (int j = 1; j < points - 3; ++j) {
    if (j % spacing == 0) continue;
    const int first = stride * (j - 1);
    T jump[3], squares = 0;
    for (int a = 0; a < 3; ++a) {
      jump[a] = 0;
      for (int i = 0; i < 5; ++i) jump[a] += T(kDifference[i]) * row[first + stride * i + a];
      squares += jump[a] * jump[a];
    }
    const T length = sqrt(squares + softening * softening);
    value += weight * squares / (length + softening);  // sqrt - s as printed cancels
    for (int i = 0; i < 5; ++i)
      for (int a = 0; a < 3; ++a)
        gradient[first + stride * i + a] += weight / length * T(kDifference[i]) * jump[a];
  }
  return value;
}

/// Adds the gradient of a prior on one row's curve. @param share  of the bricks that are visited in a step
SPLINEVOX_HD inline void curve_prior_vjp(const StaticPrior& prior, const float* row, int stride,
                                         int stored_points, bool pinned, float share, float* gradient) {
  static_curve_vjp(row, stride, stored_points, pinned, prior.weight / share, prior.softening, gradient);
}
SPLINEVOX_HD inline void curve_prior_vjp(const CurvePrior& prior, const float* row, int stride,
                                         int stored_points, bool pinned, float share, float* gradient) {
  if (prior.length > 0) curve_length_vjp(row, stride, stored_points, pinned, prior.length / share, gradient);
  SPLINEVOX_UNROLL for (int i = 0; i < CurvePrior::kScalars; ++i) {
    if (prior.scalar[i] > 0)
      step_lengths_vjp<float, 1>(row + prior.lane[i], stride, pinned ? 0 : 1, stored_points,
                                 prior.scalar[i] / share, gradient + prior.lane[i]);
  }
  if (prior.knots > 0)
    knot_jumps_vjp(row, stride, stored_points, prior.spacing, prior.knots / share, prior.softening, gradient);
}

}  // namespace splinevox
