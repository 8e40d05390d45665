// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace splinevox {

/// One of `count` shares of a list that as many processes work through: every count-th piece, from `index`
/// on; 0 <= index < count.
struct Share {
  int index = 0, count = 1;
  bool whole() const { return count == 1; }
  bool holds(std::int64_t piece) const { return piece % count == index; }
};

}  // namespace splinevox
