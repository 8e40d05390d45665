// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/hd.hpp"

namespace splinevox {

/// exp for the renderer: the same bits on every machine, no branch, so loops over samples become vector code.
///
/// x is clamped to [-87, 88]; 2^n times a polynomial of degree 6 on |r| <= ln 2 / 2. Relative error <= 2
/// units of rounding. Other scalars (double, dual numbers) use the library's exp, so that oracles are exact.
SPLINEVOX_INLINE float exp_(float x) {
  x = x < -87.0f ? -87.0f : x > 88.0f ? 88.0f : x;
  const float shifted = x * 1.44269504f + 12582912.0f;  // rounds to an integer in the low mantissa bits
  const float n = shifted - 12582912.0f;
  float r = std::fma(n, -0.693359375f, x);  // ln 2 in two parts
  r = std::fma(n, 2.12194440e-4f, r);
  float p = 1.9875691500e-4f;
  p = std::fma(p, r, 1.3981999507e-3f);
  p = std::fma(p, r, 8.3334519073e-3f);
  p = std::fma(p, r, 4.1665795894e-2f);
  p = std::fma(p, r, 1.6666665459e-1f);
  p = std::fma(p, r, 5.0000001201e-1f);
  p = std::fma(p, r * r, r) + 1.0f;
  const std::int32_t exponent = std::int32_t(n);
  return p * std::bit_cast<float>((exponent + 127) << 23);
}
template <class T>
SPLINEVOX_INLINE T exp_(const T& x) {
  using std::exp;
  return exp(x);
}

/// 1 - exp(-x) for x >= 0 without cancellation (numerics H8): a polynomial where exp(-x) is near 1. The plain
/// form is 0 below x = 3e-8 and off by a fifth at 1e-7: thin fog would have no alpha, or a jagged one.
SPLINEVOX_INLINE float one_minus_exp_neg(float x) {
  // Taylor to degree 7 on [0, 0.5]: error below one unit of rounding of the result.
  float p = -1.98412698e-4f;
  p = std::fma(p, x, 1.38888889e-3f);
  p = std::fma(p, x, -8.33333333e-3f);
  p = std::fma(p, x, 4.16666667e-2f);
  p = std::fma(p, x, -1.66666667e-1f);
  p = std::fma(p, x, 0.5f);
  p = std::fma(p, x, -1.0f);
  const float small = -p * x;
  const float large = 1.0f - exp_(-x);
  return x < 0.5f ? small : large;
}
template <class T>
SPLINEVOX_INLINE T one_minus_exp_neg(const T& x) {
  using std::expm1;
  return -expm1(-x);
}

/// log(1 + e) for e in [0, 1] in float: vector code, error below 3 units of rounding of the result.
SPLINEVOX_INLINE float log1p_unit(float e) {
  // log(1 + e) = 2 atanh(s), s = e / (2 + e) in [0, 1/3]; an odd series in s.
  const float s = e / (2.0f + e), z = s * s;
  float p = 2.0f / 15;
  p = std::fma(p, z, 2.0f / 13);
  p = std::fma(p, z, 2.0f / 11);
  p = std::fma(p, z, 2.0f / 9);
  p = std::fma(p, z, 2.0f / 7);
  p = std::fma(p, z, 2.0f / 5);
  p = std::fma(p, z, 2.0f / 3);
  p = std::fma(p, z, 2.0f);
  return p * s;
}
template <class T>
SPLINEVOX_INLINE T log1p_unit(const T& e) {
  using std::log1p;
  return log1p(e);
}

/// Value and first derivative.
template <class T>
struct Activated {
  T value, slope;
};

/// Logistic function and its derivative. e = exp(-|x|) keeps both accurate at either end: the naive s (1 - s)
/// is 0 from x = 17 on, and a saturated rigidity would never come back (numerics H11).
template <class T>
SPLINEVOX_INLINE Activated<T> sigmoid(T x) {
  const T e = exp_(x < T(0) ? x : -x);
  const T inv = T(1) / (T(1) + e);
  const T small = e * inv;
  return {x < T(0) ? small : inv, small * inv};
}

/// log(1 + exp(x)) and its derivative, the logistic function; finite for every finite x. The plain form is 0
/// below x = -17, where density would stop learning, and infinite from 89 on (numerics H11).
template <class T>
SPLINEVOX_INLINE Activated<T> softplus(T x) {
  const T e = exp_(x < T(0) ? x : -x);
  const T inv = T(1) / (T(1) + e);
  return {(x > T(0) ? x : T(0)) + log1p_unit(e), x < T(0) ? e * inv : inv};
}

/// The x at which softplus(x) = y, y > 0. The plain log(exp(y) - 1) is infinite from 710 on.
inline double inverse_softplus(double y) { return y + std::log(-std::expm1(-y)); }

/// The raw value that has this depth > 0: scale * softplus(raw + shift) = depth. Of a density with its own
/// scale, of an optical depth with the scale times the length.
inline double raw_of_depth(double depth, double scale, double shift) {
  return inverse_softplus(depth / scale) - shift;
}

/// The raw value at which a scale of density that is `by` times as large gives the same density as raw did.
/// Grows with raw; nothing overflows: far below it is raw - log(by), far above raw / by.
inline double raw_at_scale(double raw, double shift, double by) {
  return raw_of_depth(softplus(raw + shift).value, by, shift);
}

/// The optical depth, density times length, that has this alpha in [0, 1): the inverse of one_minus_exp_neg.
inline double optical_depth(double alpha) { return -std::log1p(-alpha); }

/// The raw value from which on a way of this length through a density has this alpha in (0, 1).
inline float raw_of_alpha(double alpha, double scale, double shift, double length) {
  return float(raw_of_depth(optical_depth(alpha), scale * length, shift));
}

}  // namespace splinevox
