// SPDX-License-Identifier: Apache-2.0
#include "io/model/exact_text.hpp"

#include <charconv>
#include <cmath>

namespace splinevox {

template <class T>
std::string exact_text(const std::vector<T>& values) {
  std::string text;
  for (const T v : values) {
    char digits[64];
    const auto end = std::to_chars(digits, digits + sizeof digits, v).ptr;
    if (!text.empty()) text += ' ';
    text.append(digits, end);
  }
  return text;
}

template <class T>
std::vector<T> parse_exact(const std::string& text, std::size_t count) {
  std::vector<T> values;
  const char *at = text.data(), *end = at + text.size();
  while (values.size() < count) {
    if (!values.empty()) {
      if (at == end || *at != ' ') return {};
      ++at;
    }
    T v{};
    const auto [stop, error] = std::from_chars(at, end, v);
    if (error != std::errc() || !std::isfinite(v)) return {};
    at = stop;
    values.push_back(v);
  }
  return at == end ? values : std::vector<T>{};
}

template std::string exact_text(const std::vector<float>&);
template std::string exact_text(const std::vector<double>&);
template std::vector<float> parse_exact(const std::string&, std::size_t);
template std::vector<double> parse_exact(const std::string&, std::size_t);

}  // namespace splinevox
