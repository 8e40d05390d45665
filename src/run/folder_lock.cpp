// SPDX-License-Identifier: Apache-2.0
#include "run/folder_lock.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string_view>

#include "core/own_folder.hpp"
#include "run/run_folder.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;

bool take_end(std::string_view& text, std::string_view end) {
  if (!text.ends_with(end)) return false;
  text.remove_suffix(end.size());
  return true;
}

/// The number at the end of a text, taken off; -1: none.
long take_number(std::string_view& text) {
  long number = -1, unit = 1;
  for (; !text.empty() && text.back() >= '0' && text.back() <= '9' && unit < 1'000'000'000; unit *= 10) {
    number = (number < 0 ? 0 : number) + unit * (text.back() - '0');
    text.remove_suffix(1);
  }
  return number;
}

bool is_alive(long process) { return ::kill(pid_t(process), 0) == 0 || errno != ESRCH; }

/// Drafts of FileWriter (NAME.PID-COUNT.tmp, checkpoint.bin.prev.tmp) and probes (.probe.PID) whose process
/// is gone.
bool is_leftover(std::string_view name) {
  std::string_view probe = name;
  if (const long process = take_number(probe); process > 0 && probe == ".probe.") return !is_alive(process);
  if (!take_end(name, ".tmp")) return false;
  if (name == std::string(kCheckpoint) + ".prev") return true;
  if (take_number(name) < 0 || !take_end(name, "-")) return false;
  const long process = take_number(name);
  return process > 0 && name.size() > 1 && name.ends_with(".") && !is_alive(process);
}

void remove_leftovers(const std::string& folder) {
  std::error_code ignored;
  for (const std::string& name : names_in_folder(folder)) {
    const fs::path path = fs::path(folder) / name;
    if (fs::is_regular_file(fs::symlink_status(path, ignored)) && is_leftover(name))
      fs::remove(path, ignored);
  }
}

}  // namespace

FolderLock::FolderLock(const std::string& folder, const char* doing, bool alone)
    : folder_(folder, O_RDONLY | O_DIRECTORY) {
  if (!folder_.ok()) return;
  if (retried([&] { return ::flock(folder_.get(), (alone ? LOCK_EX : LOCK_SH) | LOCK_NB); }) == 0) {
    held_ = true;
    if (alone) remove_leftovers(folder);
  } else if (errno == EWOULDBLOCK) {
    fail({folder, std::string("another process is ") + doing + " this folder", "one writer", "",
          "wait for it, or another folder for --out"});
  }
}

}  // namespace splinevox::run
