// SPDX-License-Identifier: Apache-2.0
#include "core/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/system.hpp"
#include "splinevox/core/error.hpp"

extern char** environ;

namespace splinevox {
namespace {

std::vector<char*> pointers(const std::vector<std::string>& words) {
  std::vector<char*> all;
  for (const std::string& w : words) all.push_back(const_cast<char*>(w.c_str()));
  return all;
}

}  // namespace

Child::Child(const ChildWords& start) {
  const std::string& program = start.words.at(0);
  int ends[2];
  if (!make_pipe(ends)) fail({start.where, "no pipe to " + program, "", std::strerror(errno), ""});
  std::vector<char*> arguments = pointers(start.words), environment;
  arguments.push_back(nullptr);
  for (char** variable = environ; *variable; ++variable) environment.push_back(*variable);
  for (const std::string& usual : start.usual)
    if (!std::getenv(usual.substr(0, usual.find('=')).c_str()))
      environment.push_back(const_cast<char*>(usual.c_str()));
  environment.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (start.errors)
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  const int error =
      ::posix_spawnp(&process_, program.c_str(), &actions, nullptr, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  pipe_ = ends[0];
  if (error == 0) return;
  process_ = -1;
  ::close(pipe_);
  fail({start.where, program + " cannot be started, and " + start.purpose, "the program " + program,
        std::strerror(error), start.hint});
}

Child::~Child() {
  kill();
  finish();
}

void Child::kill() {
  if (process_ > 0) ::kill(process_, SIGKILL);
}

bool Child::read(char* to, std::size_t size) {
  constexpr int kPatience = 60'000;  // milliseconds
  while (size > 0) {
    pollfd pipe{pipe_, POLLIN, 0};
    const int ready = ::poll(&pipe, 1, kPatience);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) {
      kill();
      return false;
    }
    const ssize_t n = ::read(pipe_, to, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    to += n;
    size -= std::size_t(n);
  }
  return true;
}

bool Child::read_line(std::string& line, const std::function<bool()>& stop) {
  constexpr int kLook = 200;  // milliseconds
  constexpr std::size_t kLongest = 100'000;
  for (;;) {
    const std::size_t end = ahead_.find_first_of("\r\n");
    if (end != std::string::npos || ahead_.size() > kLongest) {
      line = ahead_.substr(0, end);
      ahead_.erase(0, end == std::string::npos ? end : end + 1);
      return true;
    }
    if (stop && stop()) {
      kill();
      return false;
    }
    pollfd pipe{pipe_, POLLIN, 0};
    if (::poll(&pipe, 1, kLook) <= 0) continue;
    char some[4096];
    const ssize_t n = ::read(pipe_, some, sizeof some);
    if (n < 0 && errno == EINTR) continue;
    if (n > 0) {
      ahead_.append(some, std::size_t(n));
      continue;
    }
    line = std::exchange(ahead_, {});
    return !line.empty();
  }
}

bool Child::finish() {
  if (process_ <= 0) return true;
  ::close(pipe_);
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  process_ = -1;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace splinevox
