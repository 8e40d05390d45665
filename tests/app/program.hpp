// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/tiny_dataset.hpp"

extern char** environ;

/// The program as a user meets it: words in, exit code and two texts out.
namespace splinevox::test {

struct Ended {
  int code = -1;  ///< exit code, or 128 + signal
  std::string out, err;
};

/// Waits for something that another process does. False: it has not come for so long.
inline bool comes(const std::function<bool()>& about, int seconds = 120) {
  for (int tries = 0; tries < 50 * seconds; ++tries) {
    if (about()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

inline std::string slurp(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Every file of a folder, by its path there.
inline std::map<std::string, std::string> files_of(const std::string& folder) {
  std::map<std::string, std::string> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      out[std::filesystem::relative(entry.path(), folder).string()] = slurp(entry.path());
  return out;
}

/// A program that was started and not yet waited for.
class Started {
 public:
  explicit Started(std::vector<std::string> words) {
    std::vector<char*> arguments;
    for (std::string& w : words) arguments.push_back(w.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, (folder_.str() + "/out").c_str(), O_CREAT | O_WRONLY, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, (folder_.str() + "/err").c_str(), O_CREAT | O_WRONLY, 0600);
    if (posix_spawnp(&process_, arguments[0], &actions, nullptr, arguments.data(), environ) != 0)
      process_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  /// Whoever does not wait for it wants it no more, as where a check failed.
  ~Started() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;
  pid_t process() const { return process_; }
  /// What it has said on stderr so far.
  std::string err() const { return slurp(folder_.path() / "err"); }
  Ended wait() {
    Ended e;
    int status = 0;
    if (process_ > 0 && ::waitpid(std::exchange(process_, -1), &status, 0) > 0)
      e.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    e.out = slurp(folder_.path() / "out");
    e.err = slurp(folder_.path() / "err");
    return e;
  }

 private:
  TempFolder folder_;
  pid_t process_ = -1;
};

/// Where a program is that PATH leads to; empty: nowhere.
inline std::string found_in_path(const std::string& name) {
  std::stringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (::access((folder + "/" + name).c_str(), X_OK) == 0) return folder + "/" + name;
  return "";
}

/// Runs `splinevox WORDS...` to its end.
inline Ended program(std::vector<std::string> words) {
  words.insert(words.begin(), SPLINEVOX_PROGRAM);
  return Started(words).wait();
}

inline std::string between(const std::string& text, const std::string& first, const std::string& last) {
  const std::size_t from = text.find(first);
  if (from == text.npos) return "";
  const std::size_t to = text.find(last, from + first.size());
  return text.substr(from + first.size(), to - from - first.size());
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != text.npos;
}

}  // namespace splinevox::test
