// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include "core/hd.hpp"

namespace splinevox {

/// What many elements of a kernel may change at once. Relaxed: results are read after the kernel has ended.
template <std::floating_point T>
SPLINEVOX_HD inline void atomic_add(T* to, std::type_identity_t<T> value) {
#if defined(__CUDA_ARCH__)
  atomicAdd(to, value);
#else
  std::atomic_ref<T>(*to).fetch_add(value, std::memory_order_relaxed);
#endif
}
SPLINEVOX_HD inline void atomic_add(std::int64_t* to, std::int64_t value) {
#if defined(__CUDA_ARCH__)
  atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(value));
#else
  std::atomic_ref<std::int64_t>(*to).fetch_add(value, std::memory_order_relaxed);
#endif
}
SPLINEVOX_HD inline void atomic_or(std::uint64_t* to, std::uint64_t bits) {
#if defined(__CUDA_ARCH__)
  atomicOr(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(bits));
#else
  std::atomic_ref<std::uint64_t>(*to).fetch_or(bits, std::memory_order_relaxed);
#endif
}
/// The same for bits that are mostly set already: reads first, which costs other threads nothing.
SPLINEVOX_HD inline void atomic_set(std::uint64_t* to, std::uint64_t bits) {
#if defined(__CUDA_ARCH__)
  if (bits & ~*static_cast<volatile std::uint64_t*>(to)) atomic_or(to, bits);
#else
  if (bits & ~std::atomic_ref<std::uint64_t>(*to).load(std::memory_order_relaxed)) atomic_or(to, bits);
#endif
}

}  // namespace splinevox
