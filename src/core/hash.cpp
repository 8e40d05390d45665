// SPDX-License-Identifier: Apache-2.0
#include "core/hash.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace splinevox {
namespace {

static_assert(std::endian::native == std::endian::little, "files are written as the machine stores them");

constexpr std::uint64_t kPrime1 = 0x9E3779B185EBCA87ull, kPrime2 = 0xC2B2AE3D27D4EB4Full,
                        kPrime3 = 0x165667B19E3779F9ull, kPrime4 = 0x85EBCA77C2B2AE63ull,
                        kPrime5 = 0x27D4EB2F165667C5ull;

template <class T>
T load(const unsigned char* p) {
  T v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

std::uint64_t mix(std::uint64_t lane, std::uint64_t input) {
  return std::rotl(lane + input * kPrime2, 31) * kPrime1;
}

void absorb(std::uint64_t (&lane)[4], const unsigned char* block) {
  for (int i = 0; i < 4; ++i) lane[i] = mix(lane[i], load<std::uint64_t>(block + 8 * i));
}

}  // namespace

void Hash64::add(const void* data, std::size_t bytes) {
  const auto* p = static_cast<const unsigned char*>(data);
  const std::size_t held = total_ % 32;
  total_ += bytes;
  if (held > 0) {
    const std::size_t taken = std::min(bytes, 32 - held);
    if (taken > 0) std::memcpy(block_ + held, p, taken);
    p += taken;
    bytes -= taken;
    if (held + taken < 32) return;
    absorb(lane_, block_);
  }
  for (; bytes >= 32; p += 32, bytes -= 32) absorb(lane_, p);
  if (bytes > 0) std::memcpy(block_, p, bytes);
}

std::uint64_t Hash64::value() const {
  std::uint64_t h = lane_[2] + kPrime5;
  if (total_ >= 32) {
    h = std::rotl(lane_[0], 1) + std::rotl(lane_[1], 7) + std::rotl(lane_[2], 12) + std::rotl(lane_[3], 18);
    for (const std::uint64_t lane : lane_) h = (h ^ mix(0, lane)) * kPrime1 + kPrime4;
  }
  h += total_;
  const unsigned char *p = block_, *end = block_ + total_ % 32;
  for (; p + 8 <= end; p += 8) h = std::rotl(h ^ mix(0, load<std::uint64_t>(p)), 27) * kPrime1 + kPrime4;
  if (p + 4 <= end) {
    h = std::rotl(h ^ (load<std::uint32_t>(p) * kPrime1), 23) * kPrime2 + kPrime3;
    p += 4;
  }
  for (; p < end; ++p) h = std::rotl(h ^ (*p * kPrime5), 11) * kPrime1;
  h = (h ^ (h >> 33)) * kPrime2;
  h = (h ^ (h >> 29)) * kPrime3;
  return h ^ (h >> 32);
}

std::uint64_t hash64(std::string_view bytes) {
  Hash64 hash;
  hash.add(bytes);
  return hash.value();
}

}  // namespace splinevox
