// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/hd.hpp"

namespace splinevox {

/// Counter-based generator: a draw is a function of (seed, stream, index) alone, so the same on any machine,
/// in any order, on any number of threads, and after a resume. Source: the finaliser of SplitMix64 (Steele et
/// al. 2014).
SPLINEVOX_HD constexpr std::uint64_t hash64(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

struct Rng {
  std::uint64_t key;
  SPLINEVOX_HD constexpr Rng(std::uint64_t seed, std::uint64_t stream) : key(hash64(seed ^ hash64(stream))) {}
  SPLINEVOX_HD constexpr std::uint64_t bits(std::uint64_t index) const { return hash64(key ^ hash64(index)); }
  /// Uniform in [0, 1), 24 bits.
  SPLINEVOX_HD constexpr float uniform(std::uint64_t index) const {
    return float(bits(index) >> 40) * 0x1p-24f;
  }
  /// Uniform in [0, n). @pre n >= 1.
  SPLINEVOX_HD constexpr std::uint32_t below(std::uint64_t index, std::uint32_t n) const {
    return std::uint32_t(((bits(index) >> 32) * n) >> 32);
  }
};

}  // namespace splinevox
