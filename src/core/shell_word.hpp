// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace splinevox {

/// A text in quotes, as one word of a shell's.
inline std::string shell_quoted(std::string_view text) {
  std::string out(1, '\'');
  for (const char c : text)
    if (c == '\'')
      out += "'\\''";
    else
      out += c;
  out += '\'';
  return out;
}

/// The same only where a shell would take the text for more than a word.
inline std::string shell_word(std::string_view text) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string_view("_-./=,:+@%").find(c) != std::string_view::npos;
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), plain) ? std::string(text)
                                                                       : shell_quoted(text);
}

}  // namespace splinevox
