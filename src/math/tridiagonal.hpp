// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace splinevox {

/// The x of before[i] x[i - 1] + middle[i] x[i] + after[i] x[i + 1] = right[i], by elimination without
/// pivots: each middle outweighs its neighbours, or nearly. before[0] and after[n - 1] are not read.
/// @pre all of one length n
inline std::vector<double> solve_tridiagonal(std::span<const double> before, std::span<const double> middle,
                                             std::span<const double> after, std::span<const double> right) {
  const std::size_t n = middle.size();
  std::vector<double> ratio(n), x(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double pivot = i > 0 ? middle[i] - before[i] * ratio[i - 1] : middle[i];
    ratio[i] = i + 1 < n ? after[i] / pivot : 0;
    x[i] = (i > 0 ? right[i] - before[i] * x[i - 1] : right[i]) / pivot;
  }
  for (std::size_t i = n; i-- > 1;) x[i - 1] -= ratio[i - 1] * x[i];
  return x;
}

}  // namespace splinevox
