// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <mutex>
#include <string>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "core/shell_word.hpp"
#include "core/stopwatch.hpp"
#include "core/system.hpp"

namespace splinevox {

namespace {

double seconds_of(clockid_t clock) {
  timespec used{};
  ::clock_gettime(clock, &used);
  return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

double own_limit() {
  rlimit limit{};
  const bool limited = ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return limited ? double(limit.rlim_cur) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::string command_line() {
  std::string out;
  for (const std::string& word : own_command()) {
    if (!out.empty()) out += ' ';
    out += shell_word(word);
  }
  return out;
}

std::string machine_name() {
  return processor_name() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

double processor_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
double running_seconds() {
  static std::mutex mutex;
  static RunningClock clock;
  const std::lock_guard lock(mutex);
  return clock(seconds_of(CLOCK_MONOTONIC), processor_seconds());
}
double thread_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

double free_memory() {
  const auto machine = machine_memory();
  const double own = std::max(1.0, own_limit() - double(mapped_memory().value_or(0)));
  return machine ? std::min(std::max(1.0, machine->left), own) : 0;
}

double total_memory() {
  const auto machine = machine_memory();
  return machine ? std::min(machine->most, own_limit()) : 0;
}

double usable_memory() {
  constexpr double kShare = 0.8;  // the rest is for the system and its cache of files
  const double most = total_memory();
  return most == 0 ? std::numeric_limits<double>::infinity() : std::min(kShare * most, free_memory());
}

double peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * peak_memory_unit();
}

void release_freed_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace splinevox
