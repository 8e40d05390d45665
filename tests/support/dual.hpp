// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace splinevox::test {

/// a + b eps with eps^2 = 0: sent through a formula it returns the exact derivative in b. The oracle of every gradient test.
struct Dual {
  double a = 0, b = 0;
  constexpr Dual() = default;
  constexpr Dual(double value, double slope = 0) : a(value), b(slope) {}
  constexpr Dual& operator+=(Dual y) { return *this = {a + y.a, b + y.b}; }
  constexpr Dual& operator-=(Dual y) { return *this = {a - y.a, b - y.b}; }
  constexpr Dual& operator*=(Dual y) { return *this = {a * y.a, a * y.b + b * y.a}; }
  friend constexpr Dual operator+(Dual x, Dual y) { return x += y; }
  friend constexpr Dual operator-(Dual x, Dual y) { return x -= y; }
  friend constexpr Dual operator-(Dual x) { return {-x.a, -x.b}; }
  friend constexpr Dual operator*(Dual x, Dual y) { return x *= y; }
  friend constexpr Dual operator/(Dual x, Dual y) { return {x.a / y.a, (x.b * y.a - x.a * y.b) / (y.a * y.a)}; }
  friend constexpr bool operator<(Dual x, Dual y) { return x.a < y.a; }
  friend constexpr bool operator>(Dual x, Dual y) { return x.a > y.a; }
};

inline Dual sqrt(Dual x) { const double r = std::sqrt(x.a); return {r, x.b / (2 * r)}; }
inline Dual exp(Dual x) { const double e = std::exp(x.a); return {e, e * x.b}; }
inline Dual expm1(Dual x) { return {std::expm1(x.a), std::exp(x.a) * x.b}; }
inline Dual log(Dual x) { return {std::log(x.a), x.b / x.a}; }
inline Dual log1p(Dual x) { return {std::log1p(x.a), x.b / (1 + x.a)}; }
inline Dual pow(Dual x, Dual y) { return exp(y * log(x)); }

}  // namespace splinevox::test
