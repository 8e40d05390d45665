// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace splinevox {

inline constexpr float kLargestHalf = 65504;
inline constexpr std::uint16_t kHalfOne = 0x3c00;

/// A number of 16 bits as OpenEXR's half and IEEE 754's binary16 have it. Source: IEEE 754-2008, 3.4.
inline float from_half(std::uint16_t h) {
  const std::uint32_t sign = std::uint32_t(h & 0x8000u) << 16, exponent = h >> 10 & 31u,
                      fraction = h & 0x3ffu;
  if (exponent == 31) return std::bit_cast<float>(sign | 0x7f800000u | fraction << 13);
  if (exponent > 0) return std::bit_cast<float>(sign | (exponent + 112) << 23 | fraction << 13);
  const float small = std::ldexp(float(fraction), -24);
  return sign ? -small : small;
}

/// The nearest one, ties to even. @pre 0 <= v <= kLargestHalf
inline std::uint16_t to_half(float v) {
  if (v < 0x1p-14f) return std::uint16_t(std::nearbyint(std::ldexp(v, 24)));
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(v);
  const std::uint32_t even = bits >> 13 & 1;
  return std::uint16_t((bits - (112u << 23) + 0xfffu + even) >> 13);
}

}  // namespace splinevox
