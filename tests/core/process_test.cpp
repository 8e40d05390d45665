// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "core/stopwatch.hpp"

using namespace splinevox;

TEST_SUITE("core/process") {
  TEST_CASE("processor time grows with work, and memory in use with what is written to") {
    const double start = processor_seconds(), before = peak_memory();
    CHECK(before > 1e6);
    std::vector<char> block(std::size_t(before) + (64u << 20));
    for (std::size_t i = 0; i < block.size(); i += 512) block[i] = char(i);
    CHECK(peak_memory() >= before + (64u << 20));
    while (processor_seconds() <= start) block[0] ^= 1;
    CHECK(processor_seconds() > start);
    const double of_thread = thread_seconds();  // first: both clocks run on
    CHECK(of_thread <= processor_seconds());
    CHECK(free_memory() > 1e6);
  }

  TEST_CASE("a process that was suspended has not been awake, one that waits for its turn has") {
    RunningClock clock;
    CHECK(clock(100, 5) == 100);
    CHECK(clock(100.5, 5) == 100.5);                       // a short wait
    CHECK(clock(160.5, 5.01) == doctest::Approx(100.51));  // a minute asleep
    CHECK(clock(162.5, 5.06) == doctest::Approx(102.51));  // slow, on a busy machine
    CHECK(clock(162.6, 5.16) == doctest::Approx(102.61));
    const double before = running_seconds();
    CHECK(running_seconds() >= before);
  }

  TEST_CASE("a clock stands still while its process is stopped, also where a step was under way") {
    RunningClock clock;
    const double begin = clock(100, 7);
    CHECK(clock(100.5, 7.4) - begin == doctest::Approx(0.5));
    // Stopped for 4 s; the step before and after it took two threads 50 ms of processor time.
    CHECK(clock(104.5, 7.45) - begin == doctest::Approx(0.55));
    // A busy machine: a tenth of a processor for 3 s is work.
    CHECK(clock(107.5, 7.75) - begin == doctest::Approx(3.55));
    CHECK(clock(108.4, 7.75) - begin == doctest::Approx(4.45));  // to wait for less than a second is too
  }
}
