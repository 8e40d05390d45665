// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "data/layouts/npy_file.hpp"

namespace splinevox::data {

/// Some arrays of a .npz file, as numpy.savez and numpy.savez_compressed write it. Source of the container:
/// PKWARE's APPNOTE.TXT, 4.3; of its compression RFC 1951.
/// @param names  those that are wanted. Throws Error (Fault::input) for one that is not there, naming those
/// that are, for a damaged file, and as parse_npy.
std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where,
                                         const std::vector<std::string>& names);

/// All arrays, by name. Throws as read_npz, but numbers need not be finite.
std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where);

/// The array of that name, or the only one there is. Throws as read_npz, but numbers need not be finite.
NpyArray read_npz_array(const std::filesystem::path& path, const std::string& where, const std::string& name);

}  // namespace splinevox::data
