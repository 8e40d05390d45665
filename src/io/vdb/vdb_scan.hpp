// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/vdb/vdb_file.hpp"
#include "io/vdb/vdb_walk.hpp"

namespace splinevox {

inline constexpr std::size_t kVdbIdOffset = 21;  ///< of the file's unique id
inline constexpr std::size_t kVdbIdBytes = 36;   ///< of a UUID as text
inline constexpr std::size_t kVdbSealBytes = 24;

/// The seal that closes a file of ours: magic, length and hash of what stands before.
std::string vdb_seal(std::uint64_t bytes_before, std::uint64_t hash_before);

struct VdbScan {
  std::string_view payload;  ///< the file without its seal
  bool sealed = false;
  VdbCost cost;  ///< of all grids
};

/// Checks what can be checked without OpenVDB: the seal, the header, and every length, count and block of all
/// grids against the file's own size and the limits (walk_grid). Throws Error (Fault::input) naming `path`.
VdbScan scan_vdb(const std::string& path, std::string_view bytes, const VdbLimits& limits);

}  // namespace splinevox
