// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace splinevox {

/// Text from files as a terminal may have it: one line that does what it shows. Control characters and bytes
/// that are no UTF-8 as \xNN; signs that turn the direction of writing, and those that end a line, as \uNNNN.
/// @param longest  bytes, about; then "..."
std::string printable(std::string_view text, std::size_t longest = 120);
/// The same of text of any length.
inline std::string all_printable(std::string_view text) { return printable(text, std::string_view::npos); }

/// Length of the UTF-8 character at the start of a text that is not empty; 0 if there is none.
std::size_t utf8_length(std::string_view text);
/// Its number. @param length  utf8_length of the text, not 0
char32_t utf8_code(std::string_view text, std::size_t length);

/// Whether a character shows nothing of itself and changes how others are shown or where they stand:
/// controls, directions of writing, ends of lines.
bool is_control(char32_t code);

}  // namespace splinevox
