// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>
#include <utility>

namespace splinevox {

/// Calls body(i) for every i in [0, n), on the threads of the calling TBB arena, in no particular order. The
/// one place that knows how loops are run; results must not depend on the order (each i writes what is its
/// own). An exception from a body is rethrown here.
void parallel_for(int n, void (*body)(void* context, int i), void* context);

template <class Body>
void parallel_for(int n, Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  parallel_for(
      n, [](void* context, int i) { (*static_cast<Plain*>(context))(i); },
      const_cast<void*>(static_cast<const void*>(&body)));
}

/// Threads the calling arena may use, >= 1.
int thread_count();

}  // namespace splinevox
