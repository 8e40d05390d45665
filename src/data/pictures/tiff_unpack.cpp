// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/tiff_unpack.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace splinevox::data {
namespace {

using In = std::span<const std::uint8_t>;
using Out = std::span<std::uint8_t>;

bool inflate_all(In in, Out out) {
  uLongf size = out.size();
  const int code = ::uncompress(out.data(), &size, in.data(), in.size());
  return size == out.size() && (code == Z_OK || code == Z_BUF_ERROR);  // more than is wanted is no fault
}

bool unpack_bits(In in, Out out) {
  std::size_t at = 0, made = 0;
  while (made < out.size()) {
    if (at >= in.size()) return false;
    const int n = static_cast<signed char>(in[at++]);
    if (n == -128) continue;
    const std::size_t count = std::size_t(n >= 0 ? n + 1 : 1 - n), fits = std::min(count, out.size() - made);
    const std::size_t taken = n >= 0 ? count : 1;
    if (taken > in.size() - at) return false;
    for (std::size_t i = 0; i < fits; ++i) out[made + i] = in[at + (n >= 0 ? i : 0)];
    at += taken;
    made += fits;
  }
  return true;
}

/// TIFF 6.0, section 13: codes of 9 to 12 bits, the highest first, which get longer one code early.
bool unpack_lzw(In in, Out out) {
  constexpr int kClear = 256, kEnd = 257, kFirst = 258, kMost = 4096;
  std::array<std::uint16_t, kMost> length{};
  std::array<std::size_t, kMost> begin{};  // where in `out` a code's text stands
  int next = kFirst, bits = 9, previous = -1;
  std::size_t made = 0, last = 0;
  std::uint32_t buffer = 0;
  int held = 0;
  for (std::size_t at = 0; made < out.size();) {
    while (held < bits && at < in.size()) {
      buffer = buffer << 8 | in[at++];
      held += 8;
    }
    if (held < bits) return false;
    const int code = int(buffer >> (held - bits) & ((1u << bits) - 1));
    held -= bits;
    if (code == kEnd) return false;
    if (code == kClear) {
      next = kFirst;
      bits = 9;
      previous = -1;
      continue;
    }
    if (code > next || (code == next && previous < 0) || (code >= kFirst && previous < 0)) return false;
    const std::size_t start = made;
    const std::size_t size = code < 256 ? 1 : code < next ? length[std::size_t(code)] : made - last + 1;
    const std::size_t from = code < 256 ? 0 : code < next ? begin[std::size_t(code)] : last;
    for (std::size_t i = 0; i < size && made < out.size(); ++i, ++made)
      out[made] = code < 256 ? std::uint8_t(code) : out[from + i];
    if (previous >= 0 && next < kMost) {  // the text before and the first letter of this one
      begin[std::size_t(next)] = last;
      length[std::size_t(next)] = std::uint16_t(start - last + 1);
      ++next;
    }
    if (next + 1 >= 1 << bits && bits < 12) ++bits;
    previous = code;
    last = start;
  }
  return true;
}

}  // namespace

bool tiff_unpack(TiffPacking packing, In packed, Out out) {
  switch (packing) {
    case TiffPacking::plain:
      if (packed.size() < out.size()) return false;
      std::copy_n(packed.begin(), out.size(), out.begin());
      return true;
    case TiffPacking::lzw:
      return unpack_lzw(packed, out);
    case TiffPacking::packbits:
      return unpack_bits(packed, out);
    case TiffPacking::deflate:
    case TiffPacking::old_deflate:
      return inflate_all(packed, out);
  }
  return false;
}

}  // namespace splinevox::data
