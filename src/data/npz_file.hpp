// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "data/layouts/npy_file.hpp"

namespace splinevox::data {

/// A .npz file, as numpy.savez and numpy.savez_compressed write it. Its bytes are read at once, its arrays
/// when they are asked for. Source of the container: PKWARE's APPNOTE.TXT, 4.3; of its compression RFC 1951.
class NpzFile {
 public:
  /// Throws Error (Fault::input) for a damaged file, as all below do.
  NpzFile(const std::filesystem::path& path, std::string where);

  /// Of all arrays, as they lie in the file.
  std::vector<std::string> names() const;
  /// Throws as parse_npy. @pre it is there. @param any  numbers need not be finite
  NpyArray array(const std::string& name, bool any) const;

 private:
  /// Of the directory at the file's end.
  struct Entry {
    std::string name;
    std::uint32_t method, checksum, packed, size, at;
  };
  std::vector<std::uint8_t> unpack(const Entry& entry) const;

  std::string where_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Entry> entries_;
};

/// Some arrays of a file. @param names  those that are wanted. Throws Error (Fault::input) for one that is
/// not there, naming those that are, and as NpzFile.
std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where,
                                         const std::vector<std::string>& names);

/// The array of that name, or the only one there is. Throws as read_npz, but numbers need not be finite.
NpyArray read_npz_array(const std::filesystem::path& path, const std::string& where, const std::string& name);

}  // namespace splinevox::data
