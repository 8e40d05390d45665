// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/nearest.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/train/config_keys.hpp"

/// Text of one number of a Config and back, by the type of the member. Shared by config.cpp (--set) and
/// config_text.cpp (TOML).
namespace splinevox::config_value {

template <class T>
struct IsList : std::false_type {};
template <class T>
struct IsList<std::vector<T>> : std::true_type {};

/// Where a value came from, for error messages.
struct Source {
  std::string where;  ///< "--set" or "file.toml, line 12"
  std::string key;    ///< "group.name"
  double lo, hi;
};

/// "a number in [lo, hi]", "true or false", "bezier or bspline", ...
template <class T>
std::string expected(double lo, double hi) {
  if constexpr (IsList<T>::value) {
    return "a list; each element " + expected<typename T::value_type>(lo, hi);
  } else if constexpr (std::is_enum_v<T>) {
    std::string text;
    for (const Choice<T>& c : choices<T>()) text += (text.empty() ? "" : " or ") + std::string(c.name);
    return text;
  } else if constexpr (std::is_same_v<T, bool>) {
    return "true or false";
  } else {
    const char* kind = std::is_integral_v<T> ? "a whole number" : "a number";
    if (lo <= -1e30 && hi >= 1e30) return kind;
    if (hi >= 1e30) return fmt::format("{} >= {}", kind, lo);
    return fmt::format("{} in [{}, {}]", kind, lo, hi);
  }
}

template <class T>
[[noreturn]] void refuse(const Source& s, const char* what, const std::string& got) {
  fail({s.where, fmt::format("'{}' {}", s.key, what), expected<T>(s.lo, s.hi), got, ""});
}

/// One scalar from text. Enum names, true/false, or a number within [lo, hi] (compared in the member's own
/// type, so that a bound that is not a float of its own is still accepted).
template <class T>
T parse(std::string_view text, const Source& s) {
  if constexpr (std::is_enum_v<T>) {
    for (const Choice<T>& c : choices<T>())
      if (text == c.name) return c.value;
    refuse<T>(s, "has no such choice", std::string(text));
  } else if constexpr (std::is_same_v<T, bool>) {
    if (text == "true" || text == "1") return true;
    if (text == "false" || text == "0") return false;
    refuse<T>(s, "is not a switch", std::string(text));
  } else {
    T value{};
    const char* end = text.data() + text.size();
    const auto r = std::from_chars(text.data(), end, value);
    if (r.ec == std::errc::result_out_of_range) refuse<T>(s, "is out of range", std::string(text));
    if (r.ec != std::errc() || r.ptr != end)
      refuse<T>(s, "is not a number of the right kind", std::string(text));
    if constexpr (std::is_same_v<T, float>) {
      if (!(value >= float(s.lo) && value <= float(s.hi))) refuse<T>(s, "is out of range", std::string(text));
    } else {
      if (!(double(value) >= s.lo && double(value) <= s.hi))
        refuse<T>(s, "is out of range", std::string(text));
    }
    return value;
  }
}

/// Text that `parse` turns back into exactly the same value; also TOML.
template <class T>
std::string print(const T& value) {
  if constexpr (IsList<T>::value) {
    std::string text;
    for (const auto& v : value) text += (text.empty() ? "" : ", ") + print(v);
    return "[" + text + "]";
  } else if constexpr (std::is_enum_v<T>) {
    return fmt::format("\"{}\"", choice_name(value));
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else {
    return fmt::format("{}", value);  // the shortest text that reads back as the same number
  }
}

/// Every key, in the order of visit_config.
inline std::vector<std::string> keys() {
  std::vector<std::string> all;
  const Config c;
  visit_config(c, [&](const char* key, const auto&, const char*, double, double) { all.emplace_back(key); });
  return all;
}

[[noreturn]] inline void unknown_key(const std::string& where, const std::string& key) {
  const std::string near = nearest(key, keys());
  fail({where, "there is no setting '" + key + "'",
        "one of the keys that `splinevox train --list-settings` prints", key,
        near + "  (the nearest known key)"});
}

}  // namespace splinevox::config_value
