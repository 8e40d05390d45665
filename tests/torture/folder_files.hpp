// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "core/atomic_file.hpp"

namespace splinevox::torture {

/// Hash of every file below a folder that has to be there, by relative path.
std::map<std::string, FileDigest> files_of(const std::string& folder);

/// Files whose bytes hold the time of day, the clock or the folder's own name: only the others are compared.
bool differs_anyway(const std::string& path);

std::uint64_t total(const std::map<std::string, FileDigest>& files);

/// What is wrong with the files that a program left, against those it should have: drafts and other bytes.
/// Empty: nothing. @param found  may be fewer, where the program said that it failed
std::string what_is_wrong(const std::map<std::string, FileDigest>& found,
                          const std::map<std::string, FileDigest>& good);

}  // namespace splinevox::torture
