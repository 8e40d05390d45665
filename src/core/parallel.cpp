// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace splinevox {

void parallel_for(int n, void (*body)(void* context, int i), void* context) {
  if (n == 1) return body(context, 0);
  tbb::parallel_for(0, n, [=](int i) { body(context, i); });
}

int thread_count() { return tbb::this_task_arena::max_concurrency(); }

}  // namespace splinevox
