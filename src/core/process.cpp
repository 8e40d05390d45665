// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <sys/resource.h>

#include <ctime>
#include <fstream>
#include <limits>
#include <mutex>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "core/stopwatch.hpp"

namespace splinevox {

namespace {

double seconds_of(clockid_t clock) {
  timespec used{};
  ::clock_gettime(clock, &used);
  return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

}  // namespace

double processor_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
double running_seconds() {
  static std::mutex mutex;
  static RunningClock clock;
  const std::lock_guard lock(mutex);
  return clock(seconds_of(CLOCK_MONOTONIC), processor_seconds());
}
double thread_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

double free_memory() {
  std::ifstream file("/proc/meminfo");
  for (std::string key; file >> key; file.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (double kilobytes = 0; key == "MemAvailable:" && file >> kilobytes) return 1024 * kilobytes;
  return 0;
}

double peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * 1024;
}

void release_freed_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace splinevox
