// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Folders that this program writes into: those of runs, exports and pictures. They may come from strangers,
/// as an archive does, and must not lead anywhere else.
namespace splinevox {

enum class Depth {
  entries,  ///< what is in the folder
  all       ///< and in the folders within
};

/// Throws Error (input) naming the entry if a link in the folder leads out of it or nowhere, or if something
/// is there that is neither a file nor a folder (a pipe, a device). The folder itself may be reached through
/// a link: whoever called chose it. A folder that is not there holds nothing.
void check_own_folder(const std::string& folder, Depth depth);

/// Names of what is in a folder, in no order; none if there is no such folder, or a file. Throws Error
/// (input). Unlike the standard library's iterators it does not end the program where memory ends, nor stop
/// at a signal.
std::vector<std::string> names_in_folder(const std::string& folder);

/// The first of `names` that is among those of a folder; "": none is.
std::string first_taken(const std::vector<std::string>& folder, const std::vector<std::string>& names);

/// Adds to the end of a file, or begins it. A link, pipe or device is left alone.
/// @return false if the file did not take it
bool append_to_file(const std::string& path, std::string_view text);

/// Makes a folder unless it is there. @return whether there is one of that name, and no link
bool make_inner_folder(const std::string& path);

/// A name for a draft in the folder of `path` that nobody can foresee: hidden, with 16 random digits.
std::string draft_name(const std::string& path);

}  // namespace splinevox
