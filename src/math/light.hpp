// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"

namespace splinevox {

/// Gain of the light of a place at a time and its derivative: 2 sigmoid(l) in (0, 2), 1 at l = 0, so that a
/// light switched on later leaves the picture as it was.
///
/// Not in the paper: l(x, t) is a spline of *observed* space on the motion lattice, with the basis of the
/// control points. Shadows and highlights that wander over a surface are then not motion, which would borrow
/// their colour from elsewhere.
template <class T>
SPLINEVOX_INLINE Activated<T> light_gain(T l) {
  const Activated<T> s = sigmoid(l);
  return {T(2) * s.value, T(2) * s.slope};
}

}  // namespace splinevox
