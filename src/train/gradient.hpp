// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "field/lattice/row_mask.hpp"
#include "splinevox/field/channels.hpp"

namespace splinevox {

/// Gradient of one value array: same rows, plus which rows it touches. Rows outside the mask are zero.
struct Gradient {
  Channels values;
  std::vector<RowMask> touched;  ///< [bricks + 1]
  /// [bricks + 1] rows that rays have shown, over many steps; empty: not kept. A ray shows the rows around
  /// those of its samples whose weight T alpha is at least min_weight and `seen_share` of its largest: of
  /// smoke every sample, of a surface none behind it; of fog none, where the picture has nothing but
  /// background (has_matter).
  std::vector<RowMask> seen;

  explicit Gradient(const Channels& of);
  Gradient() = default;
};

/// Above it a number, summed over levels, would soon have no square in float, and one NaN let into the
/// moments would stay (numerics H31). Needs a build in which NaN exists, hence no -ffast-math.
inline constexpr float kLargestGradient = 1e16f;
inline bool usable(float g) { return std::abs(g) < kLargestGradient; }

/// Whether every number of the touched rows of a brick is usable.
bool usable(const Gradient& gradient, int brick);
/// Touched rows with a number that is not.
std::int64_t unusable_rows(const Gradient& gradient);
/// Forgets a gradient: rows 0, nothing touched.
void discard(Gradient& gradient);

}  // namespace splinevox
