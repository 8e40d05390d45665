// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace splinevox {

/// Size and XXH64 of a file: what a manifest records of it.
struct FileDigest {
  std::uint64_t size = 0;  ///< bytes
  std::uint64_t hash = 0;
  friend bool operator==(const FileDigest&, const FileDigest&) = default;
};

}  // namespace splinevox
