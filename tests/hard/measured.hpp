// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace splinevox::test {

/// Units of rounding: half the distance from 1 to the next number.
inline constexpr double kUnit = 0x1p-24, kUnitDouble = 0x1p-53;

/// The largest value seen; a NaN stays.
struct Worst {
  double value = 0;
  void see(double x) {
    if (!(x <= value)) value = x;
  }
};

/// Checks a measured figure against its limit and prints it, so that the table of docs/numerics.md can be
/// made again: `test_hard | grep -o 'measured H.*'`.
inline void measured(const char* what, double value, double limit, const char* unit = "u") {
  char text[200];
  std::snprintf(text, sizeof text, "measured %s: %.3g %s (limit %.3g)", what, value, unit, limit);
  MESSAGE(text);
  CHECK(value <= limit);
}
/// The same for a figure that must not fall below its limit.
inline void measured_least(const char* what, double value, double limit, const char* unit) {
  char text[200];
  std::snprintf(text, sizeof text, "measured %s: %.3g %s (at least %.3g)", what, value, unit, limit);
  MESSAGE(text);
  CHECK(value >= limit);
}

}  // namespace splinevox::test
