// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace splinevox::test {

/// a + b eps with eps^2 = 0: sent through a formula it returns the exact derivative in b. The oracle of every
/// gradient test.
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
  friend constexpr Dual operator/(Dual x, Dual y) {
    return {x.a / y.a, (x.b * y.a - x.a * y.b) / (y.a * y.a)};
  }
  friend constexpr bool operator<(Dual x, Dual y) { return x.a < y.a; }
  friend constexpr bool operator>(Dual x, Dual y) { return x.a > y.a; }
};

inline Dual sqrt(Dual x) {
  const double r = std::sqrt(x.a);
  return {r, x.b / (2 * r)};
}
inline Dual exp(Dual x) {
  const double e = std::exp(x.a);
  return {e, e * x.b};
}
inline Dual expm1(Dual x) { return {std::expm1(x.a), std::exp(x.a) * x.b}; }
inline Dual log(Dual x) { return {std::log(x.a), x.b / x.a}; }
inline Dual log1p(Dual x) { return {std::log1p(x.a), x.b / (1 + x.a)}; }
inline Dual pow(Dual x, Dual y) { return exp(y * log(x)); }

/// A value with kSlopes derivatives at once: as many parameters for little more than the price of one.
struct Duals {
  static constexpr int kSlopes = 16;
  double a = 0, b[kSlopes] = {};
  constexpr Duals() = default;
  constexpr Duals(double value) : a(value) {}
  /// Value `y` whose slopes are `scale` times those of x.
  static constexpr Duals chain(double y, double scale, const Duals& x) {
    Duals out(y);
    for (int i = 0; i < kSlopes; ++i) out.b[i] = scale * x.b[i];
    return out;
  }
  constexpr Duals& operator+=(const Duals& y) {
    a += y.a;
    for (int i = 0; i < kSlopes; ++i) b[i] += y.b[i];
    return *this;
  }
  constexpr Duals& operator-=(const Duals& y) {
    a -= y.a;
    for (int i = 0; i < kSlopes; ++i) b[i] -= y.b[i];
    return *this;
  }
  constexpr Duals& operator*=(const Duals& y) {
    for (int i = 0; i < kSlopes; ++i) b[i] = a * y.b[i] + b[i] * y.a;
    a *= y.a;
    return *this;
  }
  friend constexpr Duals operator+(Duals x, const Duals& y) { return x += y; }
  friend constexpr Duals operator-(Duals x, const Duals& y) { return x -= y; }
  friend constexpr Duals operator-(const Duals& x) { return chain(-x.a, -1, x); }
  friend constexpr Duals operator*(Duals x, const Duals& y) { return x *= y; }
  friend constexpr Duals operator/(const Duals& x, const Duals& y) {
    return x * chain(1 / y.a, -1 / (y.a * y.a), y);
  }
  friend constexpr bool operator<(const Duals& x, const Duals& y) { return x.a < y.a; }
  friend constexpr bool operator>(const Duals& x, const Duals& y) { return x.a > y.a; }
};

inline Duals exp(const Duals& x) { return Duals::chain(std::exp(x.a), std::exp(x.a), x); }
inline Duals expm1(const Duals& x) { return Duals::chain(std::expm1(x.a), std::exp(x.a), x); }
inline Duals log(const Duals& x) { return Duals::chain(std::log(x.a), 1 / x.a, x); }
inline Duals log1p(const Duals& x) { return Duals::chain(std::log1p(x.a), 1 / (1 + x.a), x); }
inline Duals pow(const Duals& x, const Duals& y) { return exp(y * log(x)); }
inline Duals sqrt(const Duals& x) {
  const double root = std::sqrt(x.a);
  return Duals::chain(root, 0.5 / root, x);
}

}  // namespace splinevox::test
