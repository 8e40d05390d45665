// SPDX-License-Identifier: Apache-2.0
#include "app/signals.hpp"

#include <unistd.h>

#include <csignal>

namespace splinevox::app {
namespace {

volatile std::sig_atomic_t g_stop = 0;

extern "C" void on_signal(int signal) {
  if (g_stop != 0) ::_exit(128 + signal);
  g_stop = signal;
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

int stop_signal() { return g_stop; }

}  // namespace splinevox::app
