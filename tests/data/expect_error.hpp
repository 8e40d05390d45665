// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

#include "splinevox/core/error.hpp"

namespace splinevox::test {

/// The full message of the input error by which `action` refuses; empty if it throws none.
inline std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(error.fault == Fault::input);
    CHECK_FALSE(error.problem.where.empty());
    CHECK_FALSE(error.problem.what.empty());
    return error.what();
  }
  return "";
}

/// The same of an `action` that must throw; the test fails if it throws none.
inline std::string error_of(const std::function<void()>& action) {
  const std::string message = refusal(action);
  if (message.empty()) FAIL_CHECK("no error was thrown");
  return message;
}

/// `action` must throw an input error whose message holds every one of `parts`.
inline void expect_error(const std::function<void()>& action, const std::vector<std::string>& parts) {
  const std::string message = error_of(action);
  CAPTURE(message);
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(message.find(part) != std::string::npos);
  }
}

}  // namespace splinevox::test
