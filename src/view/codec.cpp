// SPDX-License-Identifier: Apache-2.0
#include "view/codec.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>

#include "splinevox/core/error.hpp"

namespace splinevox::run {

std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  std::vector<std::uint8_t> out(size);
  if (compress2(out.data(), &size, bytes.data(), uLong(bytes.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
    fail_output({"the page", "its data could not be compressed", "", "zlib ran out of memory", ""});
  out.resize(size);
  return out;
}

std::uint16_t Quantiser::operator()(float v) const {
  const float steps = float((1 << bits) - 1);
  const float s = hi > lo ? (v - lo) / (hi - lo) * steps : 0;
  if (!(s > 0)) return 0;  // also NaN
  return std::uint16_t(std::lround(std::min(s, steps)));
}

void append_plane(std::vector<std::uint8_t>& out, std::span<const std::uint16_t> values, int bits) {
  const std::size_t start = out.size(), n = values.size();
  out.resize(start + (bits > 8 ? 2 : 1) * n);
  std::uint16_t last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint16_t difference = std::uint16_t(values[i] - last);
    last = values[i];
    if (bits > 8) {
      const auto d = std::int16_t(difference);
      const auto folded = std::uint16_t((d << 1) ^ (d >> 15));
      out[start + i] = std::uint8_t(folded);
      out[start + n + i] = std::uint8_t(folded >> 8);
    } else {
      const auto d = std::int8_t(difference);
      out[start + i] = std::uint8_t((d << 1) ^ (d >> 7));
    }
  }
}

std::vector<std::uint16_t> read_plane(std::span<const std::uint8_t> bytes, std::size_t count, int bits) {
  std::vector<std::uint16_t> out(count);
  const std::uint32_t mask = bits > 8 ? 0xffff : 0xff;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t folded = bytes[i] | (bits > 8 ? std::uint32_t(bytes[count + i]) << 8 : 0u);
    last = (last + ((folded >> 1) ^ (0u - (folded & 1)))) & mask;
    out[i] = std::uint16_t(last);
  }
  return out;
}

}  // namespace splinevox::run
