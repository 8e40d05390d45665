// SPDX-License-Identifier: Apache-2.0
// The same loops on plain threads, for builds with the thread sanitizer. It does not see into TBB, whose
// hand-over of every task would be reported as a race; here it sees all there is: threads begin and are
// joined, and nothing else orders one task after another.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/parallel.hpp"

namespace splinevox {
namespace {

/// OpenVDB calls TBB by itself: without workers its loops run on the thread that calls.
const tbb::global_control no_workers(tbb::global_control::max_allowed_parallelism, 1);

thread_local bool inside = false;  ///< of a loop; one within it runs where it is

}  // namespace

void parallel_for(int n, void (*body)(void* context, int i), void* context) {
  const int threads = inside ? 1 : std::min(n, thread_count());
  std::mutex mutex;
  std::exception_ptr error;
  // Every thread takes its share, however late it starts: a race shows whether or not the two meet.
  const auto work = [&](int first) {
    const bool outer = std::exchange(inside, true);
    try {
      for (int i = first; i < n; i += threads) body(context, i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
    inside = outer;
  };
  {
    std::vector<std::jthread> team;
    for (int t = 1; t < threads; ++t) team.emplace_back(work, t);
    work(0);
  }
  if (error) std::rethrow_exception(error);
}

int thread_count() { return tbb::this_task_arena::max_concurrency(); }

}  // namespace splinevox
