// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/pack.hpp"
#include "field/columns.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

/// One row's share of d loss / d time of a slice: its gradient there times sum_k w'_k p_k of every curve.
/// @param row  control points. @param first, last  the points whose weight is not zero
SPLINEVOX_HD inline float row_slope(const MotionLayout& layout, const float* row,
                                    const BasisWeights<float>& weights_dt, int first, int last,
                                    const float* slice_gradient) {
  float sum = 0;
  for (int k = first; k < last; ++k) {
    const float* p = row + layout.stride * k;
    float along = 0;
    if (layout.displaces)
      for (int a = 0; a < 3; ++a) along += p[a] * slice_gradient[a];
    SPLINEVOX_UNROLL for (int i = 0; i < kScalars; ++i) {
      if (layout.scalar[i] >= 0) along += p[layout.scalar[i]] * slice_gradient[kSliceScalars + i];
    }
    sum += weights_dt[k] * along;
  }
  return sum;
}

}  // namespace splinevox
