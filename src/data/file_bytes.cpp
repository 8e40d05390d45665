// SPDX-License-Identifier: Apache-2.0
#include "data/file_bytes.hpp"

#include <algorithm>
#include <fstream>
#include <string_view>

#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace fs = std::filesystem;

namespace {

/// What `git clone` leaves in place of a large file if Git LFS was not there.
void check_no_pointer(const std::vector<std::uint8_t>& bytes, const std::string& where) {
  constexpr std::string_view kStart = "version https://git-lfs";
  if (!begins_with(bytes, kStart)) return;
  fail({where, "this is a pointer of Git LFS, not the file itself", "the file's own bytes",
        "a text that names the file", "run git lfs pull where the data was cloned"});
}

}  // namespace

bool begins_with(std::span<const std::uint8_t> bytes, std::string_view mark) {
  return bytes.size() >= mark.size() &&
         std::equal(mark.begin(), mark.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return std::uint8_t(a) == b; });
}

std::uintmax_t file_size_of(const fs::path& path, const std::string& where) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) fail({where, "the file does not exist", "", "", ""});
  if (fs::exists(status) && !fs::is_regular_file(status))
    fail({where, "this is not a file", "a regular file",
          fs::is_directory(status) ? "a folder" : "a device or pipe", ""});
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) fail({where, "the file cannot be read", "a readable file", error.message(), ""});
  return size;
}

std::vector<std::uint8_t> read_bytes(const fs::path& path, const std::string& where, std::uintmax_t limit,
                                     std::uintmax_t first) {
  const std::uintmax_t size = file_size_of(path, where);
  if (size > limit)
    fail({where, "the file is too large", "at most " + std::to_string(limit) + " bytes",
          std::to_string(size) + " bytes", ""});
  std::vector<std::uint8_t> bytes(std::min(size, first));
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
  if (!in)
    fail({where, "the file cannot be read", std::to_string(bytes.size()) + " bytes",
          std::to_string(in.gcount()) + " bytes", "check its permissions"});
  check_no_pointer(bytes, where);
  return bytes;
}

}  // namespace splinevox::data
