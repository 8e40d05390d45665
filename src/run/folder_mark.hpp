// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "run/support.hpp"

namespace splinevox::run {

/// A file that says which verb wrote what is in a folder: an object whose `format` does. Files of the same
/// names without it are somebody else's and are not replaced.
struct FolderMark {
  const char* name;    ///< of the file
  const char* format;  ///< what its field `format` says
};

/// Whether a folder has it. Throws Error (input) where a file of its name is no JSON.
bool has_mark(const std::string& folder, const FolderMark& mark);

/// Writes it. @param more  further fields. Throws Error (output).
void write_mark(const std::string& folder, const FolderMark& mark, const Json& more = Json::object());

}  // namespace splinevox::run
