// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace splinevox {

/// XXH64 with seed 0, fed piece by piece: the checksum of every file this project writes. It finds damage,
/// not forgery. Source: the xxHash specification (Collet), section XXH64. Little-endian hosts only, as is the
/// rest of the file code.
class Hash64 {
 public:
  void add(const void* data, std::size_t bytes);
  void add(std::string_view text) { add(text.data(), text.size()); }
  /// The hash of everything added so far; more may follow.
  std::uint64_t value() const;

 private:
  std::uint64_t lane_[4] = {0x60EA27EEADC0B5D6ull, 0xC2B2AE3D27D4EB4Full, 0, 0x61C8864E7A143579ull};
  std::uint64_t total_ = 0;
  unsigned char block_[32] = {};  ///< the bytes of an unfinished block: total_ % 32 of them
};

std::uint64_t hash64(std::string_view bytes);

}  // namespace splinevox
