// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "splinevox/field/topology.hpp"

namespace splinevox {

/// Allocates on cache lines, so that a row of 8 or 16 floats never straddles two.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};
template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

/// Floats a row of `columns` takes: a whole number of vector registers.
constexpr int padded_width(int columns) { return (columns + 7) / 8 * 8; }

/// One value array over a topology: rows of `width` floats (a multiple of 8: one or more vector registers).
struct Channels {
  TopologyPtr topology;
  int width = 0;
  AlignedVector<float> values;  ///< [topology->rows() * width]

  float* row(std::size_t r) { return values.data() + r * width; }
  const float* row(std::size_t r) const { return values.data() + r * width; }
};

/// Every row set to `background` ([width] floats).
Channels make_channels(TopologyPtr topology, int width, const float* background);

/// Numbers of the bricks that have a row above `raw` in the first column or lie next to one, ascending: every
/// cell with such a corner has all its corners in them.
std::vector<std::int32_t> bricks_above(const Channels& channels, float raw);
/// The topology of some of the bricks. @param bricks  numbers, ascending
TopologyPtr keep_bricks(const Topology& topology, const std::vector<std::int32_t>& bricks);
/// Leaves of rows ([bricks + 1] * 512 * width) those of the background and of some bricks, in place; what
/// they took is theirs until shrink_to_fit.
void keep_rows(const std::vector<std::int32_t>& bricks, int width, AlignedVector<float>& rows);

}  // namespace splinevox
