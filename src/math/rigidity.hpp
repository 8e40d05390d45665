// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"

namespace splinevox {

/// Rigidity below which nothing moves, and dividing a displacement by it would only raise noise.
inline constexpr float kLeastRigidity = 0.02f;

/// What multiplies a displacement, in [0, 1], and its derivative: 1 moves, 0 is static (the paper's name is
/// inverted). @param offset  MotionField::rigidity_offset
template <class T>
SPLINEVOX_INLINE Activated<T> rigidity_of(T raw, T offset) {
  return sigmoid(raw + offset);
}

}  // namespace splinevox
