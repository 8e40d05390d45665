// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/parallel.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <string>

#include "splinevox/core/error.hpp"

TEST_SUITE("core/parallel") {
  TEST_CASE("F22: an exception in any of 1000 tasks becomes that one error") {
    for (int bad = 0; bad < 1000; ++bad) {
      std::atomic<int> done = 0;
      std::string message;
      try {
        splinevox::parallel_for(1000, [&](int i) {
          if (i == bad) splinevox::fail({"task " + std::to_string(i), "cannot be done", "", "", ""});
          ++done;
        });
      } catch (const splinevox::Error& error) {
        message = error.what();
      }
      CHECK(message == "task " + std::to_string(bad) + ": cannot be done");
      CHECK(done < 1000);
    }
  }
}
