// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "io/splat/spz.hpp"
#include "io/splat/voxel_splats.hpp"
#include "math/logit.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

template <class T>
void append(std::string& bytes, const T& value) {
  static_assert(std::endian::native == std::endian::little);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

char byte_of(double v) { return char(std::uint8_t(std::lround(std::clamp(v, 0.0, 255.0)))); }

std::string gzip(const std::string& bytes) {
  constexpr int kGzip = 15 + 16, kMemory = 8;
  z_stream stream{};
  if (::deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string out(::deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  const int ended = ::deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  if (ended != Z_STREAM_END) throw std::bad_alloc();
  return out;
}

/// Bits behind the point with which the largest coordinate fits into 24 bits.
int fractional_bits(const std::vector<Vec3>& places) {
  float most = 0;
  for (const Vec3& p : places) most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  constexpr int kBits = 22, kMost = 20;  // one of the 24 is the sign, one is for rounding
  return std::clamp(kBits - (most > 0 ? std::ilogb(most) + 1 : 0), 0, kMost);
}

}  // namespace

std::string splat_ply(const VoxelSplats& s) {
  const int count = s.count();
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment splinevox\nelement vertex " +
                      std::to_string(s.places.size()) + "\n";
  const auto property = [&](const std::string& name) { bytes += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) property(name);
  for (int j = 0; j < 3 * (count - 1); ++j) property("f_rest_" + std::to_string(j));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    property(name);
  bytes += "end_header\n";
  bytes.reserve(bytes.size() + s.places.size() * sizeof(float) * std::size_t(14 + 3 * count));
  const float size = float(std::log(s.size));
  for (std::size_t i = 0; i < s.places.size(); ++i) {
    append(bytes, s.places[i]);
    append(bytes, Vec3{0, 0, 0});
    const float* values = s.harmonics.data() + i * std::size_t(3 * count);
    for (int c = 0; c < 3; ++c) append(bytes, values[c]);
    for (int c = 0; c < 3; ++c)
      for (int j = 1; j < count; ++j) append(bytes, values[3 * j + c]);
    append(bytes, logit(s.opacities[i]));
    append(bytes, Vec3{size, size, size});
    for (const float r : {1.0f, 0.0f, 0.0f, 0.0f}) append(bytes, r);
  }
  return bytes;
}

std::string splat_spz(const VoxelSplats& s) {
  constexpr std::uint32_t kMagic = 0x5053474e, kVersion = 2;
  constexpr std::uint8_t kAntialiased = 1;
  constexpr double kColor = 0.15 * 255, kMiddle = 127.5;
  const int count = s.count(), bits = fractional_bits(s.places);
  std::string bytes;
  append(bytes, kMagic);
  append(bytes, kVersion);
  append(bytes, std::uint32_t(s.places.size()));
  for (const int v : {s.degree, bits, int(kAntialiased), 0}) append(bytes, std::uint8_t(v));
  for (const Vec3& p : s.places)
    for (int a = 0; a < 3; ++a) {
      const long fixed = std::lround(std::ldexp(double(p[a]), bits));
      for (int shift = 0; shift < 24; shift += 8) bytes += char(fixed >> shift & 255);
    }
  for (const float opacity : s.opacities) bytes += byte_of(255 * double(opacity));
  const std::size_t row = std::size_t(3 * count);
  for (std::size_t i = 0; i < s.places.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) bytes += byte_of(kColor * double(s.harmonics[i * row + c]) + kMiddle);
  bytes.append(3 * s.places.size(), byte_of((std::log(s.size) + 10) * 16));
  bytes.append(3 * s.places.size(), byte_of(kMiddle));
  for (std::size_t i = 0; i < s.places.size(); ++i)
    for (std::size_t j = 3; j < row; ++j) bytes += byte_of(128 * double(s.harmonics[i * row + j]) + 128);
  if (bytes.size() >> 31)
    fail({.where = "--profile",
          .what = "spz has no room for a frame of so many voxels",
          .expected = "less than 2 GiB before compression",
          .got = std::to_string(s.places.size()) + " splats",
          .hint = "a larger --voxel-size or --min-alpha"});
  return gzip(bytes);
}

}  // namespace splinevox
