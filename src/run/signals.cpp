// SPDX-License-Identifier: Apache-2.0
#include "run/signals.hpp"

#include <unistd.h>

#include <csignal>

namespace splinevox::run {
namespace {

volatile std::sig_atomic_t g_stop = 0;

extern "C" void on_signal(int signal) {
  if (g_stop == signal) ::_exit(1);
  if (g_stop == 0)
    g_stop = signal;  // another kind is the same wish by another way: a batch system's, and that of the pool
                      // it stops
}

}  // namespace

void ignore_write_signals() {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

void catch_stop_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool stop_asked() { return g_stop != 0; }

}  // namespace splinevox::run
