// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/bernstein.hpp"

namespace splinevox {

/// Where a time lies among `pieces` equal parts of [0, 1].
template <class T>
struct Piece {
  int index = 0;
  T u{};  ///< within it, [0, 1]
};

template <class T>
constexpr Piece<T> piece_of(int pieces, T t) {
  Piece<T> p;
  while (p.index + 1 < pieces && !(t * T(pieces) < T(p.index + 1))) ++p.index;
  p.u = t * T(pieces) - T(p.index);
  return p;
}

/// Poly-Bezier: cubic Bezier pieces of equal length in time that share their end points. Each point is local
/// to one piece or two; the curve goes through every third.
/// @param points  K = 3 pieces + 1.
template <class T>
constexpr BasisWeights<T> poly_bezier_weights(int points, T t) {
  const Piece<T> at = piece_of((points - 1) / 3, t);
  const BasisWeights<T> b = bernstein_weights(4, at.u);
  BasisWeights<T> w{};
  for (int j = 0; j < 4; ++j) w[3 * at.index + j] = b[j];
  return w;
}

/// d w_k / d t of poly_bezier_weights; of the later piece where two meet. Sums to 0.
template <class T>
constexpr BasisWeights<T> poly_bezier_weights_dt(int points, T t) {
  const int pieces = (points - 1) / 3;
  const Piece<T> at = piece_of(pieces, t);
  const BasisWeights<T> b = bernstein_weights_dt(4, at.u);
  BasisWeights<T> w{};
  for (int j = 0; j < 4; ++j) w[3 * at.index + j] = T(pieces) * b[j];
  return w;
}

/// Cubic Hermite: nodes evenly spaced in time, point 2 i the place at node i and point 2 i + 1 the velocity
/// there (scene units per unit of time). Weights of the places sum to 1. Written as the Bezier piece with the
/// same ends and velocities.
/// @param points  K = 2 nodes, at least 4.
template <class T>
constexpr BasisWeights<T> hermite_weights(int points, T t) {
  const int pieces = points / 2 - 1;
  const Piece<T> at = piece_of(pieces, t);
  const BasisWeights<T> b = bernstein_weights(4, at.u);
  const T third = T(1) / T(3 * pieces);
  BasisWeights<T> w{};
  w[2 * at.index] = b[0] + b[1];
  w[2 * at.index + 1] = third * b[1];
  w[2 * at.index + 2] = b[2] + b[3];
  w[2 * at.index + 3] = T(0) - third * b[2];
  return w;
}

/// d w_k / d t of hermite_weights. Those of the places sum to 0.
template <class T>
constexpr BasisWeights<T> hermite_weights_dt(int points, T t) {
  const int pieces = points / 2 - 1;
  const Piece<T> at = piece_of(pieces, t);
  const BasisWeights<T> b = bernstein_weights_dt(4, at.u);
  const T third = T(1) / T(3);
  BasisWeights<T> w{};
  w[2 * at.index] = T(pieces) * (b[0] + b[1]);
  w[2 * at.index + 1] = third * b[1];
  w[2 * at.index + 2] = T(pieces) * (b[2] + b[3]);
  w[2 * at.index + 3] = T(0) - third * b[2];
  return w;
}

}  // namespace splinevox
