// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/handle.hpp"

namespace splinevox::run {

/// What a FolderLock says of who writes frames or pictures: export, import, render.
inline constexpr const char* kWriting = "writing into";

/// The right to write into a folder, which one process has at a time, or several that share the work; ends
/// with the object or the process, however that ends. A file system without locks is no reason to stop.
class FolderLock {
 public:
  /// @param doing  what the other process does, for the message: "training into", kWriting
  /// Throws Error (input) if another process has it. Removes what a process that was killed left half written
  /// in the folder: drafts of write_file and probes.
  /// @param alone  false: beside others that say so, too; nothing is removed
  FolderLock(const std::string& folder, const char* doing, bool alone = true);
  /// Whether it was had: where a file system knows no locks, others may write as well.
  bool held() const { return held_; }

 private:
  Handle folder_;
  bool held_ = false;
};

}  // namespace splinevox::run
