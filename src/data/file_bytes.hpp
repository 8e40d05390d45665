// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox::data {

/// The most that is read at once: bytes of a file, pixels of a picture (2 GiB at 16 bit RGBA).
inline constexpr std::uintmax_t kLargestFile = std::uintmax_t(4) << 30;
inline constexpr std::uint64_t kMostPixels = std::uint64_t(1) << 28;

/// The size of a plain file. Throws Error (Fault::input) if it is absent or something else (a folder, a
/// pipe).
std::uintmax_t file_size_of(const std::filesystem::path& path, const std::string& where);

/// The whole file, or its first `first` bytes. Throws Error (Fault::input) if it cannot be read, is longer
/// than `limit` bytes, or is a pointer of Git LFS (for which at least 23 bytes must be read).
std::vector<std::uint8_t> read_bytes(const std::filesystem::path& path, const std::string& where,
                                     std::uintmax_t limit, std::uintmax_t first = UINTMAX_MAX);

/// How files of numpy, archives (.npz), OpenEXR files and JPEGs begin.
inline constexpr std::string_view kNpyMark = "\x93NUMPY", kZipMark = "PK\x03\x04",
                                  kExrMark = "\x76\x2f\x31\x01", kJpegMark = "\xff\xd8\xff";
/// Whether a file, or its start, begins like that.
bool begins_with(std::span<const std::uint8_t> bytes, std::string_view mark);

}  // namespace splinevox::data
