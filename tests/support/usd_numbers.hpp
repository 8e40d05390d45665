// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace splinevox::test {

/// Numbers behind an attribute in USD's text: its one value, or that of a frame.
/// @param name  with its type or without
inline std::vector<double> usd_numbers(const std::string& text, const std::string& name, int frame) {
  const std::size_t at = text.find(" " + name);
  REQUIRE(at != std::string::npos);
  std::size_t begin = text.find('=', at) + 1;
  if (text.compare(at + 1 + name.size(), 12, ".timeSamples") == 0) {
    begin = text.find("        " + std::to_string(frame) + ": ", at);
    REQUIRE(begin != std::string::npos);
    begin = text.find(':', begin) + 1;
  }
  std::vector<double> numbers;
  for (const char *c = text.data() + begin, *end = text.data() + text.find('\n', begin); c < end;) {
    char* behind = nullptr;
    const double value = std::strtod(c, &behind);
    if (behind != c) numbers.push_back(value);
    c = behind != c ? behind : c + 1;
  }
  return numbers;
}

}  // namespace splinevox::test
