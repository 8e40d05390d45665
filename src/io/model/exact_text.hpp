// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox {

/// Numbers separated by spaces, each in the fewest decimal digits that give back the same bits, in every
/// locale.
template <class T>
std::string exact_text(const std::vector<T>& values);

/// The inverse. Empty if `text` is anything but `count` finite numbers.
template <class T>
std::vector<T> parse_exact(const std::string& text, std::size_t count);

extern template std::string exact_text(const std::vector<float>&);
extern template std::string exact_text(const std::vector<double>&);
extern template std::vector<float> parse_exact(const std::string&, std::size_t);
extern template std::vector<double> parse_exact(const std::string&, std::size_t);

}  // namespace splinevox
