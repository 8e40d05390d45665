// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/process.hpp"

#include <sys/resource.h>

#include <ctime>

namespace splinevox {

double processor_seconds() {
  timespec used{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

double peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * 1024;
}

}  // namespace splinevox
