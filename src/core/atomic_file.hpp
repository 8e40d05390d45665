// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "splinevox/core/file_digest.hpp"

namespace splinevox {

/// Writes a whole file, or leaves what was there untouched: a temporary file beside it, fsync, rename, fsync
/// of the folder. Whoever reads `path` at any moment, also after a crash or a power cut, finds the old bytes
/// or the new ones.
///
/// Every call throws Error (Fault::output) naming the file and the system's reason (full disk, permission,
/// missing folder). A file size limit is such a reason and no signal. A link stays a link, permissions stay
/// as they were; devices and pipes are written in place.
class FileWriter {
 public:
  /// @param bytes  that will be added, for an error to tell.
  FileWriter(const std::string& path, std::uint64_t bytes);
  /// Without commit nothing was written, but for what a device or pipe has had.
  ~FileWriter();
  /// Hands bytes to the system, which need not have them on disk yet.
  void add(std::string_view part);
  /// Waits for the disk, and puts the file in its place. Once, and last.
  /// @param previous  if not empty and `path` exists, the old file is kept under this name in the same
  /// folder; there is no moment without a file at `path`.
  FileDigest commit(const std::string& previous = "");

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// All of that at once. @param parts  the bytes, in order; they are not copied.
FileDigest write_file(const std::string& path, std::initializer_list<std::string_view> parts,
                      const std::string& previous = "");

/// Bytes of all parts, and all of them as one.
/// @{
std::uint64_t total_size(std::span<const std::string_view> parts);
std::vector<char> joined(std::span<const std::string_view> parts);
/// @}

/// Reads a whole file. Throws Error (Fault::input) if it cannot be read or is larger than `max_bytes`.
std::string read_file(const std::string& path, std::uint64_t max_bytes = std::uint64_t(8) << 30);

/// Size and hash of a file on disk. Throws Error (Fault::input) if it cannot be read.
FileDigest digest_file(const std::string& path);

}  // namespace splinevox
