// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include "core/rng.hpp"

namespace splinevox::torture {

/// Draws that depend on (seed, index) alone.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t index) : rng_(hash64(seed ^ hash64(index)), 1) {}
  std::uint64_t bits() { return rng_.bits(n_++); }
  /// In [0, n); 0 for n = 0.
  std::size_t below(std::size_t n) { return n ? std::size_t(bits() % n) : 0; }
  /// In [lo, hi].
  int between(int lo, int hi) { return lo + int(below(std::size_t(hi - lo + 1))); }
  /// Once in n.
  bool once_in(std::size_t n) { return below(n) == 0; }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return *(all.begin() + std::ptrdiff_t(below(all.size())));
  }
  template <class T>
  void shuffle(std::vector<T>& all) {
    for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[below(i)]);
  }

 private:
  Rng rng_;
  std::uint64_t n_ = 0;
};

}  // namespace splinevox::torture
