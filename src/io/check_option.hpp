// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include "io/model/exact_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

/// Throws Error (Fault::input) naming the option unless `ok`.
inline void check_option(bool ok, const char* option, const char* expected, const std::string& got) {
  if (!ok) fail({.where = option, .what = "is out of range", .expected = expected, .got = got, .hint = ""});
}

/// A number as it was given, for the message; any number at all.
inline std::string option_text(double v) {
  return std::isfinite(v) ? exact_text<double>({v}) : std::to_string(v);
}

}  // namespace splinevox
