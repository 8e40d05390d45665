// SPDX-License-Identifier: Apache-2.0
#include "core/spawn.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

#include "core/handle.hpp"

extern char** environ;

namespace splinevox {
namespace {

bool is_set(const std::string& name_and_value) {
  return std::getenv(name_and_value.substr(0, name_and_value.find('=')).c_str()) != nullptr;
}

}  // namespace

pid_t spawn(const Spawn& start) {
  std::vector<char*> arguments, environment;
  for (const std::string& w : start.words) arguments.push_back(const_cast<char*>(w.c_str()));
  arguments.push_back(nullptr);
  for (char** variable = environ; *variable; ++variable) environment.push_back(*variable);
  for (const std::string& usual : start.usual)
    if (!is_set(usual)) environment.push_back(const_cast<char*>(usual.c_str()));
  environment.push_back(nullptr);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  const auto lead = [&](int stream, int to, int how) {
    if (to == kNothing) posix_spawn_file_actions_addopen(&streams, stream, "/dev/null", how, 0);
    if (to >= 0) posix_spawn_file_actions_adddup2(&streams, to, stream);
  };
  lead(STDIN_FILENO, start.input, O_RDONLY);
  lead(STDOUT_FILENO, start.output, O_WRONLY);
  lead(STDERR_FILENO, start.errors, O_WRONLY);
  posix_spawnattr_t group;
  posix_spawnattr_init(&group);
  if (start.own_group) posix_spawnattr_setflags(&group, POSIX_SPAWN_SETPGROUP);
  pid_t process = -1;
  const int error =
      ::posix_spawnp(&process, start.program.c_str(), &streams, &group, arguments.data(), environment.data());
  posix_spawnattr_destroy(&group);
  posix_spawn_file_actions_destroy(&streams);
  errno = error;
  return error == 0 ? process : -1;
}

bool ended_well(pid_t process) {
  int status = 0;
  return retried([&] { return ::waitpid(process, &status, 0); }) == process && WIFEXITED(status) &&
         WEXITSTATUS(status) == 0;
}

}  // namespace splinevox
