// SPDX-License-Identifier: Apache-2.0
#include "core/own_folder.hpp"

#include <sys/random.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <random>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

bool leads_within(const fs::path& link, const fs::path& folder) {
  std::error_code error;
  const fs::path target = fs::canonical(link, error);
  if (error) return false;
  const fs::path from_folder = target.lexically_relative(folder);
  return !from_folder.empty() && *from_folder.begin() != "..";
}

void check_entry(const fs::directory_entry& entry, const fs::path& root) {
  std::error_code ignored;
  const fs::file_status status = entry.symlink_status(ignored);
  if (fs::is_symlink(status)) {
    if (!leads_within(entry.path(), root))
      fail({entry.path().string(), "is a link that leads out of its folder",
            "files of this folder alone, since they are read and written",
            fs::read_symlink(entry.path(), ignored).string(),
            "remove the link, or put the file itself there, or choose another folder"});
  } else if (!fs::is_regular_file(status) && !fs::is_directory(status)) {
    fail({entry.path().string(), "is neither a file nor a folder", "files and folders alone",
          "a pipe, a socket or a device", "remove it, or choose another folder"});
  }
}

}  // namespace

void check_own_folder(const std::string& folder, Depth depth) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return;
  for (fs::recursive_directory_iterator at(root, error), end; !error && at != end; at.increment(error)) {
    check_entry(*at, root);
    if (depth == Depth::entries) at.disable_recursion_pending();
  }
  if (error) fail({folder, "this folder cannot be looked through", "", error.message(), ""});
}

bool append_to_file(const std::string& path, std::string_view text) {
  Handle file(path, O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_NONBLOCK);
  struct stat info {};
  const bool plain = file.ok() && ::fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode);
  return plain && write_all(file.get(), text) && file.close();
}

bool make_inner_folder(const std::string& path) {
  ::mkdir(path.c_str(), 0777);
  struct stat info {};
  return ::lstat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode);
}

std::string draft_name(const std::string& path) {
  std::uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) != ssize_t(sizeof number)) {
    std::random_device source;
    number = std::uint64_t(source()) << 32 | source();
  }
  const fs::path whole(path);
  std::string name = ".";  // appends, because g++ 12 sees an overlap in "." + text that is not there
  name += whole.filename().string();
  name += '.';
  for (int i = 60; i >= 0; i -= 4) name += "0123456789abcdef"[number >> i & 15];
  name += ".tmp";
  return (whole.parent_path() / name).string();
}

}  // namespace splinevox
