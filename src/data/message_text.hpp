// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/printable.hpp"

/// How text from the user's files appears in messages: one line, printable, of bounded length.
namespace splinevox::data {

using splinevox::printable;
/// printable() in single quotes.
std::string in_quotes(std::string_view text);
/// Up to 9 significant digits: "0.5", "1e+300", "nan".
std::string number(double value);
/// A time of the data: seconds since 1970 keep their fractions.
std::string time_text(double time);

}  // namespace splinevox::data
