// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

namespace splinevox {

/// Small registers of four and eight numbers: element-wise + - * / with each other and with scalars, like the
/// built-in types. The compiler's own vector types; they become whatever the target has (one AVX register for
/// eight floats). Aligned like a register: a weaker alignment of the typedef is lost under const, and with it
/// the right to read through a reference.
template <class Real>
struct Simd {
  typedef Real Four __attribute__((vector_size(4 * sizeof(Real))));
  typedef Real Eight __attribute__((vector_size(8 * sizeof(Real))));
};

/// Unaligned load and store of a whole register.
template <class V, class Real>
inline V load(const Real* p) {
  V v;
  std::memcpy(&v, p, sizeof(V));
  return v;
}
template <class V, class Real>
inline void store(Real* p, const V& v) {
  std::memcpy(p, &v, sizeof(V));
}

template <class V>
inline auto sum8(const V& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace splinevox
