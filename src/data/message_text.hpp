// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

/// How text from the user's files appears in messages: one line, printable, of bounded length.
namespace splinevox::data {

/// Control characters and bytes that are no UTF-8 as \xNN; about 120 bytes at most, then "...".
std::string printable(std::string_view text);
/// printable() in single quotes.
std::string in_quotes(std::string_view text);
/// Up to 9 significant digits: "0.5", "1e+300", "nan".
std::string number(double value);

}  // namespace splinevox::data
