// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace splinevox {

/// The value of which a share of all, [0, 1], are smaller; 0 of none. Changes the order of the values.
template <class T>
T quantile(std::vector<T>& values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace splinevox
