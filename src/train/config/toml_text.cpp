// SPDX-License-Identifier: Apache-2.0
#include "train/config/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "core/atomic_file.hpp"
#include "core/byte_order_mark.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

bool plain(char c) { return static_cast<unsigned char>(c) < 0x80; }

/// One past the end of the string whose quote stands at `i`: "...", '...' or, with `quotes` 3, one of several
/// lines.
std::size_t end_of_string(std::string_view text, std::size_t i, std::size_t quotes) {
  const std::string_view quote = text.substr(i, quotes);
  for (i += quotes; i < text.size() && (quotes == 3 || text[i] != '\n');) {
    if (text.substr(i, quotes) == quote) return i + quotes;
    i += text[i] == '\\' && quote[0] == '"' ? 2 : 1;
  }
  return std::min(i, text.size());
}

/// Whether a quote at `i` begins a string even for a parser in the midst of a wrong value, which goes on to
/// the next blank or comma.
bool begins_string(std::string_view text, std::size_t i) {
  if (i == 0 || std::string_view(" \t\r\n,").find(text[i - 1]) != std::string_view::npos) return true;
  return (text[i - 1] == '[' || text[i - 1] == '{') && begins_string(text, i - 1);
}

/// Where the first character beyond ASCII stands that is neither in a comment nor in a string of one line;
/// the text's size if nowhere.
std::size_t stray_character(std::string_view text) {
  for (std::size_t i = byte_order_mark(text); i < text.size();) {
    const std::string_view three = text.substr(i, 3);
    if (!plain(text[i])) return i;
    if (text[i] == '#') {
      i = std::min(text.find('\n', i), text.size());
    } else if (three == "\"\"\"" || three == "'''") {
      const std::size_t end = end_of_string(text, i, 3);
      if (const auto stray = std::find_if_not(text.begin() + i, text.begin() + end, plain);
          stray != text.begin() + end)
        return std::size_t(stray - text.begin());
      i = end;
    } else {
      const bool string = (text[i] == '"' || text[i] == '\'') && begins_string(text, i);
      i = string ? end_of_string(text, i, 1) : i + 1;
    }
  }
  return text.size();
}

}  // namespace

std::string toml_text(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    fail({path,
          std::filesystem::exists(path, ignored) ? "this is no file" : "there is no such configuration file",
          "a TOML file", std::filesystem::is_directory(path, ignored) ? "a folder" : "",
          "splinevox train --list-settings  (every key), or docs/scaling.md for a sweep"});
  constexpr std::uint64_t kLongest = std::uint64_t(64) << 20;  // bytes
  std::string text = read_file(path, kLongest, Named::by_user);
  if (const std::size_t stray = stray_character(text); stray < text.size())
    fail({fmt::format("{}, line {}", path, 1 + std::count(text.begin(), text.begin() + long(stray), '\n')),
          "there is a character beyond ASCII outside of comments and strings of one line with a blank before "
          "them",
          "plain letters, digits and signs",
          fmt::format("byte 0x{:02x}", static_cast<unsigned char>(text[stray])),
          "key = \"text\", on one line, for text in other scripts"});
  return text;
}

}  // namespace splinevox
