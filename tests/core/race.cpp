// SPDX-License-Identifier: Apache-2.0
// A race on purpose: the thread sanitizer must report it.
#include "core/parallel.hpp"

int main() {
  int sum = 0;
  splinevox::parallel_for(1000, [&](int i) { sum += i; });
  return sum < 0;
}
