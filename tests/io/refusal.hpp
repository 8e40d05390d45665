// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "splinevox/core/error.hpp"

namespace splinevox::test {

/// What a call says that refuses its input; empty if it does not refuse.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    CHECK(e.fault == Fault::input);
    return e.what();
  }
  return {};
}

}  // namespace splinevox::test
