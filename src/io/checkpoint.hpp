// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/atomic_file.hpp"

namespace splinevox {

/// What a resume checks before it touches the bytes.
struct CheckpointHeader {
  std::uint32_t format = 1;  ///< version of the bytes' own layout; whoever reads them decides what it accepts
  std::uint64_t config = 0;  ///< hash of the effective configuration
  std::uint64_t dataset = 0;  ///< fingerprint of the training data
  std::uint64_t step = 0;     ///< optimiser steps done
  std::string kind;           ///< what the bytes are, e.g. "trainer"
  friend bool operator==(const CheckpointHeader&, const CheckpointHeader&) = default;
};

struct Checkpoint {
  CheckpointHeader header;
  std::vector<char> bytes;
  std::string
      note;  ///< not empty: `path` could not be used and this is its .prev; says why, for the user to see
};

/// A checkpoint on its way to the disk. The system has its bytes: what they came from may change.
class PendingCheckpoint {
 public:
  /// @param pieces  the bytes, in order. Throws Error (Fault::output), as commit does, and then `path` still
  /// holds the old one.
  PendingCheckpoint(const std::string& path, const CheckpointHeader& header,
                    std::span<const std::string_view> pieces);
  /// Waits for the disk, and puts it in its place; the one before stays as `path`.prev. Once.
  FileDigest commit();

 private:
  FileWriter file_;
  std::string previous_;
};

/// Both at once.
FileDigest write_checkpoint(const std::string& path, const CheckpointHeader& header,
                            const std::vector<char>& bytes);

/// Reads a checkpoint. One that is missing, truncated, damaged or foreign is replaced by `path`.prev if that
/// is whole, and `note` says so; otherwise Error (Fault::input) says what is wrong with `path`. One written
/// by a newer version of this program is refused with both versions, and never replaced.
Checkpoint read_checkpoint(const std::string& path);

}  // namespace splinevox
