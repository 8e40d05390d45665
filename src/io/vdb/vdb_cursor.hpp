// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

namespace splinevox {

/// Reads fields in file order; any field that would pass the end throws.
class Cursor {
 public:
  Cursor(const std::string& path, std::string_view bytes, const VdbLimits& limits)
      : path_(path), bytes_(bytes), limits_(limits) {}

  template <class T>
  T take(const char* what) {
    need(sizeof(T), what);
    T v;
    std::memcpy(&v, bytes_.data() + at_, sizeof v);
    at_ += sizeof v;
    return v;
  }
  std::string_view skip(std::uint64_t n, const char* what) {
    need(n, what);
    at_ += n;
    return bytes_.substr(at_ - n, n);
  }
  /// A length and as many bytes.
  std::string_view text(const char* what) {
    const std::uint32_t n = take<std::uint32_t>(what);
    if (n > limits_.max_text)
      bad(std::string("the length of ") + what + " is out of range",
          "at most " + std::to_string(limits_.max_text) + " bytes", std::to_string(n));
    return skip(n, what);
  }
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return bytes_.size() - at_; }
  void move_to(std::uint64_t at) { at_ = at; }
  const VdbLimits& limits() const { return limits_; }
  [[noreturn]] void bad(std::string what, std::string expected = "", std::string got = "") const {
    fail({.where = path_ + ", byte " + std::to_string(at_),
          .what = std::move(what),
          .expected = std::move(expected),
          .got = std::move(got),
          .hint = "the file is damaged or not complete: copy or export it again"});
  }

 private:
  void need(std::uint64_t n, const char* what) const {
    if (n > left())
      bad(std::string("the file ends inside ") + what, std::to_string(n) + " more bytes",
          std::to_string(left()));
  }

  const std::string& path_;
  std::string_view bytes_;
  const VdbLimits& limits_;
  std::uint64_t at_ = 0;
};

}  // namespace splinevox
