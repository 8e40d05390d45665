// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"

namespace splinevox {

/// View rescale of the positional colour and its derivative: 1 - sigmoid(q) / 2 in [1/2, 1], q = sum_j sh_j
/// Y_j(d). Source: Spline-NeRF, Eq. 5.
template <class T>
SPLINEVOX_INLINE Activated<T> view_factor(T q) {
  const Activated<T> s = sigmoid(q);
  return {T(1) - T(0.5) * s.value, T(-0.5) * s.slope};
}

}  // namespace splinevox
