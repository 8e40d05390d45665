// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <string>

#include "core/in_order.hpp"
#include "splinevox/core/error.hpp"

TEST_SUITE("core/parallel") {
  TEST_CASE("F22: an exception in any of 1000 tasks becomes that one error") {
    for (int bad = 0; bad < 1000; ++bad) {
      std::string message;
      try {
        splinevox::parallel_for(1000, [&](int i) {
          if (i == bad) splinevox::fail({"task " + std::to_string(i), "cannot be done", "", "", ""});
        });
      } catch (const splinevox::Error& error) {
        message = error.what();
      }
      CHECK(message == "task " + std::to_string(bad) + ": cannot be done");
    }
    std::atomic<int> done = 0;  // and the threads work on
    splinevox::parallel_for(1000, [&](int) { ++done; });
    CHECK(done == 1000);
  }

  TEST_CASE(
      "in order: everything is worked once and finished in order, no more than asked is open, a stop begins "
      "nothing new") {
    for (const int at_once : {1, 3}) {
      std::atomic<int> open = 0, most = 0, worked = 0;
      int finished = 0;
      splinevox::in_order(
          200, at_once,
          [&](int) {
            ++worked;
            const int now = ++open;
            for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) {
            }
            splinevox::parallel_for(50, [&](int) {});
          },
          [&](int i) {
            CHECK(i == finished++);
            --open;
            return i != 120;
          });
      CHECK(most <= at_once);
      CHECK(worked == finished);
      CHECK(finished >= 121);
      CHECK(finished <= 121 + at_once);
    }
    const auto refuse = [](int i) {
      if (i == 3) splinevox::fail({"task 3", "cannot be done", "", "", ""});
    };
    CHECK_THROWS_WITH_AS(splinevox::in_order(10, 2, refuse, [](int) { return true; }),
                         "task 3: cannot be done", splinevox::Error);
    splinevox::in_order(0, 2, refuse, [](int) { return false; });
  }

  TEST_CASE("in order: an exception in one does not cut short the loops inside the others") {
    for (int round = 0; round < 50; ++round) {
      std::atomic<int> begun = 0, whole = 0;
      const auto work = [&](int i) {
        if (i == 3) splinevox::fail({"task 3", "cannot be done", "", "", ""});
        ++begun;
        std::atomic<int> done = 0;
        splinevox::parallel_for(2000, [&](int) { ++done; });
        if (done == 2000) ++whole;
      };
      CHECK_THROWS_AS(splinevox::in_order(20, 4, work, [](int) { return true; }), splinevox::Error);
      CHECK(whole == begun);
    }
  }
}
