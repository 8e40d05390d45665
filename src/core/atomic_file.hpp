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

/// Who chose a file's name, and with it what may stand under it.
enum class Named {
  by_program,  ///< a file within a folder of ours, which a stranger may have filled: no link, a regular file
  by_user      ///< links are followed; it may be a device or a pipe
};

/// Whether to return when the disk has the bytes, or as soon as the system has them.
enum class Wait { for_disk, no };

/// Writes a whole file, or leaves what was there untouched: a draft beside it, fsync, rename, fsync of the
/// folder. Whoever reads `path` at any moment, also after a crash or a power cut, finds the old bytes or the
/// new ones. The folder is held open meanwhile: draft and file are names in it, wherever it is moved to.
///
/// Every call throws Error (Fault::output) naming the file and the system's reason (full disk, permission,
/// missing folder, a link). A file size limit is such a reason and no signal. Permissions stay as they were.
/// What the user named may be a link, which stays one, or a device or pipe, which is written in place.
class FileWriter {
 public:
  /// @param bytes  that will be added, for an error to tell.
  FileWriter(const std::string& path, std::uint64_t bytes, Named named = Named::by_program);
  /// Without commit nothing was written, but for what a device or pipe has had.
  ~FileWriter();
  /// Hands bytes to the system, which need not have them on disk yet.
  void add(std::string_view part);
  /// Puts the file in its place. Once, and last.
  /// @param previous  if not empty and there is a file, the old one is kept under this name in the same
  /// folder; there is no moment without a file at `path`.
  FileDigest commit(const std::string& previous = "", Wait wait = Wait::for_disk);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// All of that at once. @param parts  the bytes, in order; they are not copied.
FileDigest write_file(const std::string& path, std::initializer_list<std::string_view> parts,
                      Named named = Named::by_program);

/// Writes to an open file until it has all of it. @return false, and errno, if it does not take it
bool write_all(int fd, std::string_view bytes);

/// Bytes of all parts, and all of them as one.
/// @{
std::uint64_t total_size(std::span<const std::string_view> parts);
std::vector<char> joined(std::span<const std::string_view> parts);
/// @}

/// Reads a whole file. Throws Error (Fault::input) if it cannot be read to its end or is larger than
/// `max_bytes`.
std::string read_file(const std::string& path, std::uint64_t max_bytes = std::uint64_t(8) << 30,
                      Named named = Named::by_program);

/// Size and hash of a file of ours on disk. Throws Error (Fault::input) if it cannot be read.
FileDigest digest_file(const std::string& path);

}  // namespace splinevox
