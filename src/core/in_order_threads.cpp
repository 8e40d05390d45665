// SPDX-License-Identifier: Apache-2.0
// The same on plain threads, for builds with the thread sanitizer: see parallel_threads.cpp.
#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/in_order.hpp"

namespace splinevox {

void in_order(int n, int at_once, const std::function<void(int i)>& work,
              const std::function<bool(int i)>& finish) {
  std::mutex mutex;
  std::condition_variable turn;
  int begun = 0, finished = 0;
  bool stopped = false;
  std::exception_ptr failed;
  const auto help = [&] {
    for (;;) {
      int i;
      {
        const std::lock_guard lock(mutex);
        if (begun == n || stopped) return;
        i = begun++;
      }
      std::exception_ptr error;
      try {
        work(i);
      } catch (...) {
        error = std::current_exception();
      }
      std::unique_lock lock(mutex);
      turn.wait(lock, [&] { return finished == i; });
      try {
        if (error && !failed) std::rethrow_exception(error);
        if (!failed && !finish(i)) stopped = true;
      } catch (...) {
        failed = std::current_exception();
        stopped = true;
      }
      ++finished;
      turn.notify_all();
    }
  };
  {
    std::vector<std::jthread> team;
    for (int t = 1; t < std::min(n, at_once); ++t) team.emplace_back(help);
    help();
  }
  if (failed) std::rethrow_exception(failed);
}

}  // namespace splinevox
