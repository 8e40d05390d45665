// SPDX-License-Identifier: Apache-2.0
#include "run/signals.hpp"

#include <time.h>
#include <unistd.h>

#include <csignal>

namespace splinevox::run {
namespace {

volatile std::sig_atomic_t g_stop = 0;
volatile std::sig_atomic_t g_stop_second = 0;  ///< of a clock that only goes on

std::sig_atomic_t now() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return std::sig_atomic_t(time.tv_sec);
}

/// The same kind again ends the program at once. Another kind is the same wish by another way: a batch
/// system's, and that of the pool it stops. So is a termination that comes twice within two seconds: a batch
/// system sends it to all, and a launcher passes it on. So is a hang-up, by the terminal and by its shell.
extern "C" void on_signal(int signal) {
  if (g_stop == signal && (signal == SIGINT || now() - g_stop_second > 2)) ::_exit(1);
  if (g_stop != 0) return;
  g_stop_second = now();
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
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // as nohup has it
}

bool stop_asked() { return g_stop != 0; }

}  // namespace splinevox::run
