// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "core/parallel.hpp"
#include "core/team.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {

/// Runs kernels on the threads of the calling TBB arena. An executor has buffers, copies, and two kinds of
/// loop; src/backend/ executor_cuda.cuh is the other one. Everything queued on an executor happens in order.
class HostExecutor {
 public:
  /// Memory of the executor, 64-byte aligned; its address is only for kernels.
  template <class T>
  class Buffer {
   public:
    T* data() { return values_.data(); }
    const T* data() const { return values_.data(); }
    std::size_t size() const { return values_.size(); }

   private:
    friend HostExecutor;
    AlignedVector<T> values_;
  };

  /// Makes room for n elements; what they hold is undefined, except that a buffer that has that size already
  /// is left alone.
  template <class T>
  void resize(Buffer<T>& buffer, std::size_t n) {
    buffer.values_.resize(n);
  }
  template <class T>
  void zero(Buffer<T>& buffer) {
    if (buffer.size() > 0) std::memset(static_cast<void*>(buffer.data()), 0, buffer.size() * sizeof(T));
  }
  template <class T>
  void upload(Buffer<T>& to, const T* from, std::size_t n) {
    resize(to, n);
    if (n > 0) std::memcpy(static_cast<void*>(to.data()), from, n * sizeof(T));
  }
  void wait() {}
  /// Waits for what was queued before.
  template <class T>
  void download(const Buffer<T>& from, T* to) {
    if (from.size() > 0) std::memcpy(static_cast<void*>(to), from.data(), from.size() * sizeof(T));
  }

  /// Calls `queue`; an executor may start all that it queues at once.
  template <class Queue>
  void together(Queue&& queue) {
    queue();
  }

  /// Calls kernel(i) for every i below kernel.count().
  template <class Kernel>
  void for_each(const Kernel& kernel) {
    constexpr std::size_t kBlock = 512;
    const std::size_t n = kernel.count();
    parallel_for(int((n + kBlock - 1) / kBlock), [&](int block) {
      for (std::size_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) kernel(i);
    });
  }
  /// Calls kernel(i, team) for every i in [0, n), each with scratch of its own.
  template <class Kernel>
  void for_teams(int n, const Kernel& kernel, std::size_t scratch_bytes) {
    constexpr int kBlock = 16;
    parallel_for((n + kBlock - 1) / kBlock, [&](int block) {
      AlignedVector<char> scratch(scratch_bytes);
      const HostTeam team(scratch.data());
      for (int i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) kernel(i, team);
    });
  }
};

}  // namespace splinevox
