// SPDX-License-Identifier: Apache-2.0
#include "core/printable.hpp"

#include <algorithm>

namespace splinevox {
namespace {

void put(std::string& out, const char* mark, char32_t value, int digits) {
  out += mark;
  for (int i = 4 * (digits - 1); i >= 0; i -= 4) out += "0123456789abcdef"[value >> i & 15];
}

}  // namespace

std::size_t utf8_length(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xc2 ? 0
                             : lead < 0xe0 ? 2
                             : lead < 0xf0 ? 3
                             : lead < 0xf5 ? 4
                                           : 0;
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return 0;
  return length;
}

char32_t utf8_code(std::string_view text, std::size_t length) {
  if (length == 1) return static_cast<unsigned char>(text[0]);
  char32_t code = static_cast<unsigned char>(text[0]) & (0x7f >> length);
  for (std::size_t i = 1; i < length; ++i) code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3f);
  return code;
}

bool is_control(char32_t c) {
  const auto within = [c](char32_t lo, char32_t hi) { return c >= lo && c <= hi; };
  return c < 0x20 || within(0x7f, 0x9f) || c == 0x61c || c == 0x200e || c == 0x200f ||
         within(0x2028, 0x202e) || within(0x2066, 0x2069);
}

std::string printable(std::string_view text, std::size_t longest) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (i >= longest) return out + "...";
    const std::string_view rest = text.substr(i);
    const std::size_t length = utf8_length(rest);
    const char32_t code = length > 0 ? utf8_code(rest, length) : 0;
    if (length < 2 && is_control(code))
      put(out, "\\x", static_cast<unsigned char>(rest[0]), 2);
    else if (is_control(code))
      put(out, "\\u", code, 4);
    else
      out += rest.substr(0, length);
    i += std::max<std::size_t>(length, 1);
  }
  return out;
}

}  // namespace splinevox
