// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/aligned.hpp"

#include <new>

#include "core/system.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kCacheLine = 64;
constexpr std::size_t kLargeArray = 2 * kLargePage;  // what a smaller one is rounded up by would be felt

std::align_val_t alignment(std::size_t bytes) {
  return std::align_val_t{bytes < kLargeArray ? kCacheLine : kLargePage};
}

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  void* const place = ::operator new(bytes, alignment(bytes));
  if (bytes >= kLargeArray) use_large_pages(place, bytes);
  return place;
}

void free_aligned(void* place, std::size_t bytes) { ::operator delete(place, alignment(bytes)); }

}  // namespace splinevox
