// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "backend/step.hpp"
#include "field/lattice/row_mask.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Gradient of one value array: same rows, plus which rows it touches. Rows outside the mask are zero.
struct Gradient {
  Channels values;
  std::vector<RowMask> touched;  ///< [bricks + 1]

  explicit Gradient(const Channels& of);
  Gradient() = default;
};

/// Needs a build in which NaN exists, hence no -ffast-math.
inline bool usable(float g) { return std::abs(g) < kLargestGradient; }

/// Whether every number of the touched rows of a brick is usable.
bool usable(const Gradient& gradient, int brick);
/// Touched rows with a number that is not.
std::int64_t unusable_rows(const Gradient& gradient);
/// Forgets a gradient: rows 0, nothing touched.
void discard(Gradient& gradient);

}  // namespace splinevox
