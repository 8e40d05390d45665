// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

/// How numbers and bytes travel inside a page. docs/formats.md describes it; assets/data.js reads it.
namespace splinevox::run {

/// A zlib stream (RFC 1950), what a browser's DecompressionStream("deflate") takes. Throws Error (output) if
/// memory runs out.
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes);

/// Floats as whole numbers 0 .. 2^bits - 1, evenly spaced over [lo, hi].
struct Quantiser {
  float lo = 0, hi = 1;  ///< hi >= lo
  int bits = 8;          ///< 1..16
  /// The nearest step; what lies outside, or is not finite, goes to the nearest end (NaN: lo).
  std::uint16_t operator()(float v) const;
  float value(std::uint16_t q) const { return lo + float(q) * (hi - lo) / float((1 << bits) - 1); }
};

/// Appends `values`, each below 2^bits, as differences from one to the next, modulo 2^8 or 2^16 and with the
/// sign in the lowest bit: first all low bytes, then, for more than 8 bits, all high ones.
void append_plane(std::vector<std::uint8_t>& out, std::span<const std::uint16_t> values, int bits);
/// What append_plane wrote at the front of `bytes`.
std::vector<std::uint16_t> read_plane(std::span<const std::uint8_t> bytes, std::size_t count, int bits);

}  // namespace splinevox::run
