// SPDX-License-Identifier: Apache-2.0
#include "core/in_order.hpp"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <exception>

namespace splinevox {

void in_order(int n, int at_once, const std::function<void(int i)>& work,
              const std::function<bool(int i)>& finish) {
  struct Worked {
    int i;
    std::exception_ptr error;
  };
  int next = 0;
  std::atomic<bool> stopped = false;
  std::exception_ptr failed;
  const auto begin = [&](tbb::flow_control& control) {
    if (next == n || stopped) control.stop();
    return next < n ? next++ : n;
  };
  // Caught here: an exception that TBB sees cancels the loops inside the others, which would end early and
  // say nothing.
  const auto middle = [&](int i) {
    Worked out{i, {}};
    try {
      tbb::this_task_arena::isolate([&] { work(i); });
    } catch (...) {
      out.error = std::current_exception();
    }
    return out;
  };
  const auto end = [&](const Worked& worked) {
    if (failed) return;
    try {
      if (worked.error) std::rethrow_exception(worked.error);
      if (!finish(worked.i)) stopped = true;
    } catch (...) {
      failed = std::current_exception();
      stopped = true;
    }
  };
  using tbb::filter_mode;
  const auto all = tbb::make_filter<void, int>(filter_mode::serial_in_order, begin) &
                   tbb::make_filter<int, Worked>(filter_mode::parallel, middle) &
                   tbb::make_filter<Worked, void>(filter_mode::serial_in_order, end);
  tbb::parallel_pipeline(std::size_t(at_once), all);
  if (failed) std::rethrow_exception(failed);
}

}  // namespace splinevox
