// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace splinevox {

/// Memory on cache lines; where it is large, in large pages if the system has them. Grids of hundreds of
/// megabytes are made anew at every refinement: in pages of 4 KiB a quarter of a short run is the system's
/// (docs/experiments/speed.md). Throws std::bad_alloc.
void* allocate_aligned(std::size_t bytes);
/// @param bytes  as they were allocated
void free_aligned(void* place, std::size_t bytes);

/// Allocates on cache lines, so that a row of 8 or 16 floats never straddles two.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_aligned(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { free_aligned(p, n * sizeof(T)); }
  friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};
template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace splinevox
