// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/hd.hpp"

namespace splinevox {

/// What an Adam or RMSProp step needs besides the row; bias corrections in double, -expm1(t log beta),
/// because 1 - beta^t in float is off by 1e-4 (numerics H23).
struct MomentFactors {
  float beta1, beta2;
  float correction1, correction2;  ///< 1 / (1 - beta^step)
  float epsilon;
};

/// @param step  of the run, from 1. Moments that begin later, on a refined lattice, are not corrected for it:
/// at 0.9 and 0.99 their steps
///              grow to 2.1 rates in the first dozen and fall back within a hundred.
inline MomentFactors moment_factors(double beta1, double beta2, double epsilon, double step) {
  const auto correction = [&](double beta) {
    return beta > 0 ? 1 / -std::expm1(step * std::log(beta)) : 1.0;
  };
  return {float(beta1), float(beta2), float(correction(beta1)), float(correction(beta2)), float(epsilon)};
}

/// Moments below are flushed to zero: subnormals would slow every later step (numerics H23). The second one
/// is a square: cut off like the first it would lose what a smaller epsilon than 1e-14, as dark scenes have,
/// still tells apart.
inline constexpr float kLeastMoment = 1e-30f, kLeastSquare = 1.2e-38f;

/// One Adam update (Kingma and Ba 2015) of a register or scalar; RMSProp is beta1 = 0.
/// @param flush  0 for a number below the limit it is given, else the number
template <class V, class Sqrt, class Flush>
SPLINEVOX_HD inline void adam_step(const MomentFactors& f, const V& rate, const V& gradient, V& m, V& v,
                                   V& parameter, Sqrt root, Flush flush) {
  m = flush(f.beta1 * m + (1.0f - f.beta1) * gradient, kLeastMoment);
  v = flush(f.beta2 * v + (1.0f - f.beta2) * gradient * gradient, kLeastSquare);
  parameter -= rate * (f.correction1 * m) / (root(f.correction2 * v) + f.epsilon);
}

}  // namespace splinevox
