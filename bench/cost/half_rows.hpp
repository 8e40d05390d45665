// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Imath/half.h>
#ifdef __F16C__
#include <immintrin.h>
#endif

#include "core/simd.hpp"

namespace splinevox {

/// A number of a radiance row kept in 16 bits.
struct Half {
  Imath::half value;
  Half(float v = 0) : value(v) {}
};

/// Eight of them as the ray kernel computes with them.
template <class V>
inline V load(const Half* p) {
#ifdef __F16C__
  return V(_mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
#else
  V v;
  for (int i = 0; i < 8; ++i) v[i] = float(p[i].value);
  return v;
#endif
}

}  // namespace splinevox
