// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

/// SPLINEVOX_HD marks a formula or kernel body that compiles for the host and for a CUDA device.
#if defined(__CUDACC__)
#define SPLINEVOX_HD __host__ __device__
#else
#define SPLINEVOX_HD
#endif

namespace splinevox {

/// Three components of one kind. Plain data: no padding, no alignment promise.
template <class T>
struct Vec3T {
  T x{}, y{}, z{};

  SPLINEVOX_HD constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  SPLINEVOX_HD constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  SPLINEVOX_HD constexpr Vec3T& operator+=(const Vec3T& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  SPLINEVOX_HD constexpr Vec3T& operator-=(const Vec3T& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  SPLINEVOX_HD constexpr Vec3T& operator*=(T s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  friend constexpr bool operator==(const Vec3T&, const Vec3T&) = default;
};

using Vec3 = Vec3T<float>;
using Vec3d = Vec3T<double>;
using Int3 = Vec3T<int>;

template <class T>
SPLINEVOX_HD constexpr Vec3T<T> operator+(Vec3T<T> a, const Vec3T<T>& b) {
  return a += b;
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> operator-(Vec3T<T> a, const Vec3T<T>& b) {
  return a -= b;
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> operator-(const Vec3T<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> operator*(Vec3T<T> a, T s) {
  return a *= s;
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> operator*(T s, Vec3T<T> a) {
  return a *= s;
}
/// Component-wise product.
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> mul(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <class T>
SPLINEVOX_HD constexpr T dot(const Vec3T<T>& a, const Vec3T<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> cross(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
SPLINEVOX_HD T length(const Vec3T<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
/// Unit vector along a. @pre length(a) > 0; the readers refuse shorter than 1e-12.
template <class T>
SPLINEVOX_HD Vec3T<T> normalize(const Vec3T<T>& a) {
  return a * (T(1) / length(a));
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> min(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z};
}
template <class T>
SPLINEVOX_HD constexpr Vec3T<T> max(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}
template <class U, class T>
SPLINEVOX_HD constexpr Vec3T<U> cast(const Vec3T<T>& a) {
  return {U(a.x), U(a.y), U(a.z)};
}

/// Axis-aligned box in scene units.
struct Box {
  Vec3 lo{}, hi{};
  SPLINEVOX_HD constexpr Vec3 extent() const { return hi - lo; }
  SPLINEVOX_HD constexpr float longest_edge() const {
    const Vec3 e = extent();
    return e.x > e.y ? (e.x > e.z ? e.x : e.z) : (e.y > e.z ? e.y : e.z);
  }
  SPLINEVOX_HD constexpr Vec3 center() const { return 0.5f * (lo + hi); }
  friend constexpr bool operator==(const Box&, const Box&) = default;
};

}  // namespace splinevox
