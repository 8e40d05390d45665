// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "core/hd.hpp"

namespace splinevox {

/// Lanes that walk along one ray together. On a device they are the threads of a warp
/// (src/backend/team_cuda.cuh); here they take turns, so that the same kernel body runs, and is tested,
/// without one. Reductions add in the order of the device's.
inline constexpr int kLanes = 32;

class HostTeam {
 public:
  /// One value per lane. On a device each thread keeps its own.
  template <class T>
  struct Lanes {
    T v[kLanes];
    T& operator[](int lane) { return v[lane]; }
    const T& operator[](int lane) const { return v[lane]; }
  };

  explicit HostTeam(char* scratch) : scratch_(scratch) {}
  /// Memory of this team, as much as the kernel asked for.
  char* scratch() const { return scratch_; }
  /// Calls body(lane) for every lane.
  template <class Body>
  void each(Body&& body) const {
    for (int lane = 0; lane < kLanes; ++lane) body(lane);
  }
  /// Another lane's value. Every lane has to ask.
  template <class T>
  T at(const Lanes<T>& x, int lane) const {
    return x[lane];
  }
  /// Makes what lanes wrote to scratch visible to the others.
  void sync() const {}
  std::uint32_t ballot(const Lanes<bool>& x) const {
    std::uint32_t bits = 0;
    for (int lane = 0; lane < kLanes; ++lane) bits |= std::uint32_t(x[lane]) << lane;
    return bits;
  }
  /// Sum over the lanes, the same in every lane.
  template <class T>
  T sum(Lanes<T> x) const {
    for (int d = kLanes / 2; d > 0; d /= 2) {
      const Lanes<T> y = x;
      for (int lane = 0; lane < kLanes; ++lane) x[lane] = y[lane] + y[lane ^ d];
    }
    return x[0];
  }
  /// Largest of the lanes, the same in every lane.
  float max(const Lanes<float>& x) const {
    float most = x[0];
    for (int lane = 1; lane < kLanes; ++lane) most = x[lane] > most ? x[lane] : most;
    return most;
  }
  /// Product over the lanes before each; returns that over all.
  float product_before(Lanes<float>& x) const {
    for (int d = 1; d < kLanes; d *= 2) {
      const Lanes<float> y = x;
      for (int lane = d; lane < kLanes; ++lane) x[lane] = y[lane] * y[lane - d];
    }
    const float all = x[kLanes - 1];
    for (int lane = kLanes - 1; lane > 0; --lane) x[lane] = x[lane - 1];
    x[0] = 1;
    return all;
  }
  /// Sum over the lanes after each; returns that over all.
  float sum_after(Lanes<float>& x) const {
    for (int d = 1; d < kLanes; d *= 2) {
      const Lanes<float> y = x;
      for (int lane = 0; lane + d < kLanes; ++lane) x[lane] = y[lane] + y[lane + d];
    }
    const float all = x[0];
    for (int lane = 0; lane + 1 < kLanes; ++lane) x[lane] = x[lane + 1];
    x[kLanes - 1] = 0;
    return all;
  }

 private:
  char* scratch_;
};

}  // namespace splinevox
