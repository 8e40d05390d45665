// SPDX-License-Identifier: Apache-2.0
#include "core/own_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "core/system.hpp"
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

/// @return whether the entry is a folder
bool check_entry(const fs::path& entry, const fs::path& root) {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(entry, ignored);
  if (!fs::exists(status)) return false;  // a draft that has got its name meanwhile
  if (fs::is_symlink(status)) {
    if (!leads_within(entry, root))
      fail({entry.string(), "is a link that leads out of its folder",
            "files of this folder alone, since they are read and written",
            fs::read_symlink(entry, ignored).string(),
            "remove the link, or put the file itself there, or choose another folder"});
  } else if (!fs::is_regular_file(status) && !fs::is_directory(status)) {
    fail({entry.string(), "is neither a file nor a folder", "files and folders alone",
          "a pipe, a socket or a device", "remove it, or choose another folder"});
  }
  return fs::is_directory(status);
}

[[noreturn]] void fail_listing(const fs::path& folder, int reason) {
  fail({folder.string(), "this folder cannot be looked through", "", std::strerror(reason), ""});
}

void check_folder(const fs::path& folder, const fs::path& root, Depth depth) {
  for (const std::string& name : names_in_folder(folder.string())) {
    const fs::path entry = folder / name;
    if (check_entry(entry, root) && depth == Depth::all) check_folder(entry, root, depth);
  }
}

}  // namespace

std::string first_taken(const std::vector<std::string>& folder, const std::vector<std::string>& names) {
  const std::set<std::string_view> taken(folder.begin(), folder.end());
  const auto found =
      std::find_if(names.begin(), names.end(), [&](const auto& n) { return taken.contains(n); });
  return found == names.end() ? "" : *found;
}

std::vector<std::string> names_in_folder(const std::string& folder) {
  const int fd =
      retried([&] { return ::openat(AT_FDCWD, folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
  if (fd < 0 && (errno == ENOENT || errno == ENOTDIR)) return {};
  if (fd < 0) fail_listing(folder, errno);
  const std::unique_ptr<DIR, int (*)(DIR*)> list(::fdopendir(fd), ::closedir);
  if (!list) {
    const int reason = errno;
    ::close(fd);
    if (reason == ENOMEM) throw std::bad_alloc();
    fail_listing(folder, reason);
  }
  std::vector<std::string> names;
  for (;;) {
    errno = 0;
    const dirent* entry = ::readdir(list.get());
    if (!entry && errno != 0) fail_listing(folder, errno);
    if (!entry) return names;
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
  }
}

void check_own_folder(const std::string& folder, Depth depth) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return;
  check_folder(root, root, depth);
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
  if (!fill_random(&number, sizeof number)) {
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
