// SPDX-License-Identifier: Apache-2.0
#include "data/message_text.hpp"

#include <fmt/format.h>

namespace splinevox::data {

std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 120;
  std::string out;
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      out += c;
    }
  }
  return text.size() > kLongest ? out + "..." : out;
}

std::string in_quotes(std::string_view text) { return fmt::format("'{}'", printable(text)); }

std::string number(double value) { return fmt::format("{:.9g}", value); }

}  // namespace splinevox::data
