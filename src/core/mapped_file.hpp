// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace splinevox {

/// A file in the address space of the process, to be read. The system reads its pages when they are touched,
/// and takes them back when memory is short.
class MappedFile {
 public:
  /// @return null if there is no such regular file, or an empty one, or it may not be read. A link counts as
  /// no file. Throws Error (input) if it cannot be mapped.
  static std::shared_ptr<const MappedFile> open(const std::string& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::span<const std::uint8_t> bytes_;
};

enum class Pages {
  soon,    ///< will be read: the system may begin to
  no_more  ///< this process needs them no more; touched again, they come back as they were
};
/// Tells the system about pages of a MappedFile. It is no error if it does not listen.
void advise(const void* first, std::size_t bytes, Pages pages);

}  // namespace splinevox
