// SPDX-License-Identifier: Apache-2.0
// Undefined behaviour on purpose: its sanitizer must report it and end the program there.
#include <cstdio>
#include <limits>

int main(int argc, char**) {
  int sum = std::numeric_limits<int>::max();
  sum += argc;
  std::printf("went on with %d\n", sum);
}
