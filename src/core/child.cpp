// SPDX-License-Identifier: Apache-2.0
#include "core/child.hpp"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/spawn.hpp"
#include "core/system.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

Child::Child(const ChildWords& start) {
  const std::string& program = start.words.at(0);
  int ends[2];
  if (!make_pipe(ends)) fail({start.where, "no pipe to " + program, "", std::strerror(errno), ""});
  process_ = spawn({.program = program,
                    .words = start.words,
                    .output = ends[1],
                    .errors = start.errors ? ends[1] : kNothing,
                    .usual = start.usual});
  const int error = errno;
  ::close(ends[1]);
  pipe_ = ends[0];
  if (process_ > 0) return;
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
  return ended_well(std::exchange(process_, -1));
}

}  // namespace splinevox
