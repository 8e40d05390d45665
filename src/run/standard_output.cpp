// SPDX-License-Identifier: Apache-2.0
#include "run/standard_output.hpp"

#include <cerrno>
#include <cstdio>

#include "core/system.hpp"

namespace splinevox::run {
namespace {

int g_failure = 0;

/// Drops what could not be written: the next lines may find room.
void lose_output() {
  if (g_failure == 0) g_failure = errno != 0 ? errno : EIO;
  drop_unwritten(stdout);
  std::clearerr(stdout);
}

}  // namespace

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0) lose_output();
}

void print_now(const std::string& text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    lose_output();
}

int output_failure() { return g_failure; }

}  // namespace splinevox::run
