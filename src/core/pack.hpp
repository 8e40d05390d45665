// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "core/hd.hpp"

namespace splinevox {

/// Four floats as one value, element by element like the registers of simd.hpp, in a form that a device
/// compiler knows too: there one load fetches all four. Formulas that are templates on their scalar take
/// either.
struct alignas(16) Pack {
  static constexpr int kSize = 4;
  float v[kSize];
  SPLINEVOX_INLINE float& operator[](int i) { return v[i]; }
  SPLINEVOX_INLINE float operator[](int i) const { return v[i]; }
  SPLINEVOX_INLINE Pack& operator+=(const Pack& b) {
    SPLINEVOX_UNROLL for (int i = 0; i < kSize; ++i) v[i] += b.v[i];
    return *this;
  }
  friend SPLINEVOX_INLINE Pack operator+(Pack a, const Pack& b) { return a += b; }
  friend SPLINEVOX_INLINE Pack operator-(const Pack& a, const Pack& b) {
    return {{a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2], a.v[3] - b.v[3]}};
  }
  friend SPLINEVOX_INLINE Pack operator*(const Pack& a, float s) {
    return {{a.v[0] * s, a.v[1] * s, a.v[2] * s, a.v[3] * s}};
  }
  friend SPLINEVOX_INLINE Pack operator*(float s, const Pack& a) { return a * s; }
};

/// @pre p on a 16-byte boundary, as every fourth column of a row is.
SPLINEVOX_INLINE Pack load_pack(const float* p) {
#if defined(__CUDA_ARCH__)
  const float4 f = *reinterpret_cast<const float4*>(p);
  return {{f.x, f.y, f.z, f.w}};
#else
  Pack a;
  std::memcpy(&a, p, sizeof a);
  return a;
#endif
}
SPLINEVOX_INLINE void store_pack(float* p, const Pack& a) {
#if defined(__CUDA_ARCH__)
  *reinterpret_cast<float4*>(p) = float4{a.v[0], a.v[1], a.v[2], a.v[3]};
#else
  std::memcpy(p, &a, sizeof a);
#endif
}

}  // namespace splinevox
