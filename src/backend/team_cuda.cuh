// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "core/team.hpp"

namespace splinevox {

/// HostTeam's counterpart: the threads of a warp, which is a row of its block. Bodies are for the device
/// alone; nvcc wants to see them from host code as well, because kernels are compiled for both.
#if defined(__CUDA_ARCH__)
#define SPLINEVOX_DEVICE_BODY(...) __VA_ARGS__
#else
#define SPLINEVOX_DEVICE_BODY(...) return {};
#endif

class DeviceTeam {
 public:
  template <class T>
  struct Lanes {
    T v;
    SPLINEVOX_HD T& operator[](int) { return v; }
    SPLINEVOX_HD const T& operator[](int) const { return v; }
  };

  SPLINEVOX_HD explicit DeviceTeam(char* scratch) : scratch_(scratch) {}
  SPLINEVOX_HD char* scratch() const { return scratch_; }
  template <class Body>
  SPLINEVOX_HD void each(Body&& body) const {
    body(lane());
  }
  SPLINEVOX_HD void sync() const {
#if defined(__CUDA_ARCH__)
    __syncwarp();
#endif
  }
  template <class T>
  SPLINEVOX_HD T at(const Lanes<T>& x, int from) const {
    return words(x.v, [from](std::uint32_t w) { SPLINEVOX_DEVICE_BODY(return __shfl_sync(kAll, w, from);) });
  }
  SPLINEVOX_HD std::uint32_t ballot([[maybe_unused]] const Lanes<bool>& x) const {
    SPLINEVOX_DEVICE_BODY(return __ballot_sync(kAll, x.v);)
  }
  template <class T>
  SPLINEVOX_HD T sum(const Lanes<T>& x) const {
    T v = x.v;
    for (int d = kLanes / 2; d > 0; d /= 2)
      v = v + words(v, [d](std::uint32_t w) { SPLINEVOX_DEVICE_BODY(return __shfl_xor_sync(kAll, w, d);) });
    return v;
  }
  SPLINEVOX_HD float max([[maybe_unused]] const Lanes<float>& x) const {
    SPLINEVOX_DEVICE_BODY(float most = x.v; for (int d = kLanes / 2; d > 0; d /= 2) most =
                                                fmaxf(most, __shfl_xor_sync(kAll, most, d));
                          return most;)
  }
  SPLINEVOX_HD float product_before([[maybe_unused]] Lanes<float>& x) const {
    SPLINEVOX_DEVICE_BODY(for (int d = 1; d < kLanes; d *= 2) {
      const float y = __shfl_up_sync(kAll, x.v, d);
      if (lane() >= d) x.v *= y;
    } const float all = __shfl_sync(kAll, x.v, kLanes - 1);
                          const float before = __shfl_up_sync(kAll, x.v, 1);
                          x.v = lane() == 0 ? 1.0f : before; return all;)
  }
  SPLINEVOX_HD float sum_after([[maybe_unused]] Lanes<float>& x) const {
    SPLINEVOX_DEVICE_BODY(for (int d = 1; d < kLanes; d *= 2) {
      const float y = __shfl_down_sync(kAll, x.v, d);
      if (lane() + d < kLanes) x.v += y;
    } const float all = __shfl_sync(kAll, x.v, 0);
                          const float after = __shfl_down_sync(kAll, x.v, 1);
                          x.v = lane() == kLanes - 1 ? 0.0f : after; return all;)
  }

 private:
  static constexpr unsigned kAll = 0xffffffffu;
  SPLINEVOX_HD static int lane() { SPLINEVOX_DEVICE_BODY(return int(threadIdx.x);) }
  /// Applies op to every 32-bit word of a value.
  template <class T, class Op>
  SPLINEVOX_HD static T words(T x, Op op) {
    static_assert(sizeof(T) % 4 == 0);
    std::uint32_t w[sizeof(T) / 4];
    memcpy(w, &x, sizeof(T));
    for (std::uint32_t& one : w) one = op(one);
    memcpy(&x, w, sizeof(T));
    return x;
  }
  char* scratch_;
};
#undef SPLINEVOX_DEVICE_BODY

}  // namespace splinevox
