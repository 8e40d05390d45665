// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>

#include "core/handle.hpp"

namespace splinevox {
namespace {

std::uint64_t mapped_now() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

[[noreturn]] void child(const std::function<void()>& task, unsigned seconds, std::uint64_t bytes, int out) {
  for (const int fault : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGALRM, SIGXCPU}) ::signal(fault, SIG_DFL);
  const rlimit no_core{0, 0}, memory{bytes, bytes};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::setrlimit(RLIMIT_AS, &memory);
  ::alarm(seconds);
  const int nowhere = ::open("/dev/null", O_WRONLY);  // the C library's last words about a broken heap
  if (nowhere >= 0) {
    ::dup2(nowhere, 2);
    ::dup2(nowhere, 1);
  }
  const char* text = nullptr;
  std::string held;
  try {
    task();
  } catch (const std::bad_alloc&) {
    text = "sizes beyond reason";
  } catch (const std::exception& e) {
    held = e.what();
    text = held.empty() ? "an error without a text" : held.c_str();
  } catch (...) {
    text = "an unknown error";
  }
  if (text && retried([&] { return ::write(out, text, strnlen(text, 1000)); }) < 0) ::_exit(2);
  ::_exit(text ? 1 : 0);
}

}  // namespace

std::string run_in_child(const std::function<void()>& task, unsigned seconds, std::uint64_t bytes) {
  int ends[2];
  if (::pipe(ends) != 0) return std::string("no pipe to a child process: ") + std::strerror(errno);
  const std::uint64_t limit = mapped_now() + bytes;
  const pid_t pid = ::fork();
  if (pid < 0) {
    const int reason = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    return std::string("no child process: ") + std::strerror(reason);
  }
  if (pid == 0) {
    ::close(ends[0]);
    child(task, seconds, limit, ends[1]);
  }
  ::close(ends[1]);
  std::string text;
  char buffer[1024];
  for (;;) {
    const ssize_t n = ::read(ends[0], buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    text.append(buffer, std::size_t(n));
  }
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return "reading takes forever";
  if (WIFSIGNALED(status)) return std::string("reading it crashes: ") + ::strsignal(WTERMSIG(status));
  return text.empty() ? "an unknown error" : text;
}

}  // namespace splinevox
