// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <new>
#include <vector>

#include "core/handle.hpp"
#include "core/system.hpp"
#include "io/vdb/rights.hpp"

namespace splinevox {
namespace {

enum Code { kDone = 0, kRefused = 1, kNoMemory = 3, kNull = 4, kNoPipe = 5 };
constexpr std::size_t kBuffer = std::size_t(1) << 16, kLongestText = 1000;
constexpr unsigned kPatience = 20;  ///< wall time per processor time

struct EndOfChild {};

class Pipe {
 public:
  Pipe() { good = make_pipe(ends_); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close(0);
    close(1);
  }
  int in() const { return ends_[0]; }
  int out() const { return ends_[1]; }
  void close(int end) {
    if (ends_[end] >= 0) ::close(ends_[end]);
    ends_[end] = -1;
  }
  bool good = false;

 private:
  int ends_[2] = {-1, -1};
};

void write_or_end(int fd, const char* from, std::size_t size) {
  while (size > 0) {
    const ssize_t n = retried([&] { return ::write(fd, from, size); });
    if (n <= 0) ::_exit(kNoPipe);
    from += n;
    size -= std::size_t(n);
  }
}

/// Reads until `size` bytes are there or the pipe ends. @return how many came
std::size_t read_up_to(int fd, char* to, std::size_t size) {
  std::size_t got = 0;
  while (got < size) {
    const ssize_t n = retried([&] { return ::read(fd, to + got, size - got); });
    if (n <= 0) break;
    got += std::size_t(n);
  }
  return got;
}

void on_fault(int signal, siginfo_t* info, void*) {
  constexpr std::uintptr_t kFirstPages = 1 << 16;
  if (info->si_code == SEGV_MAPERR && reinterpret_cast<std::uintptr_t>(info->si_addr) < kFirstPages)
    ::_exit(kNull);
  ::signal(signal, SIG_DFL);  // the instruction is run again, and ends the process
}

/// An exception where none may be, in a destructor say.
[[noreturn]] void on_terminate() {
  try {
    if (std::current_exception()) std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    ::_exit(kNoMemory);
  } catch (...) {
    ::abort();
  }
  ::abort();
}

/// @param beyond  the hard limit above it: at that of processor time the system kills, without saying why
void set_limit(decltype(RLIMIT_CPU) which, std::uint64_t value, std::uint64_t beyond) {
  rlimit limit{};
  ::getrlimit(which, &limit);
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, limit.rlim_cur + beyond);
  ::setrlimit(which, &limit);
}

[[noreturn]] void child(const std::function<void(const Sink&)>& task, const ChildLimits& limits, int out,
                        int words) {
  end_with_parent();
  for (const int fault : {SIGABRT, SIGBUS, SIGFPE, SIGALRM, SIGXCPU, SIGPIPE}) ::signal(fault, SIG_DFL);
  struct sigaction on_null {};
  on_null.sa_sigaction = on_fault;
  on_null.sa_flags = SA_SIGINFO;
  ::sigaction(SIGSEGV, &on_null, nullptr);
  std::set_terminate(on_terminate);
  const int nowhere = ::open("/dev/null", O_WRONLY);  // the C library's last words about a broken heap
  if (nowhere >= 0) {
    ::dup2(nowhere, 2);
    ::dup2(nowhere, 1);
  }
  int code = kDone;
  char text[kLongestText] = "";
  try {
    set_limit(RLIMIT_CPU, limits.seconds, 5);
    set_limit(RLIMIT_AS, limits.bytes, 0);
    ::alarm(kPatience * limits.seconds);
    drop_rights({1, 2, out, words});  // among them that to change limits
    std::vector<char> held;
    held.reserve(kBuffer);
    task([&](const void* from, std::size_t size) {
      const char* bytes = static_cast<const char*>(from);
      if (held.size() + size > kBuffer) {
        write_or_end(out, held.data(), held.size());
        held.clear();
      }
      if (size > kBuffer)
        write_or_end(out, bytes, size);
      else
        held.insert(held.end(), bytes, bytes + size);
    });
    write_or_end(out, held.data(), held.size());
  } catch (const std::bad_alloc&) {
    code = kNoMemory;
  } catch (const std::exception& e) {
    code = kRefused;
    std::strncpy(text, e.what(), sizeof text - 1);
  } catch (...) {
    code = kRefused;
  }
  write_or_end(words, text, ::strnlen(text, sizeof text));
  ::_exit(code);
}

ChildReport report_of(int status, std::string text) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGKILL) return {ChildEnd::no_memory};  // nobody else sends it but who frees memory
    if (signal == SIGALRM || signal == SIGXCPU) return {ChildEnd::crashed, "reading takes forever"};
    return {ChildEnd::crashed, std::string("reading it crashes: ") + ::strsignal(signal)};
  }
  switch (WEXITSTATUS(status)) {
    case kDone:
      return {};
    case kRefused:
      return {ChildEnd::refused, text.empty() ? "an error without a text" : std::move(text)};
    case kNoMemory:
      return {ChildEnd::no_memory};
    case kNull:
      return {ChildEnd::null, "reading it crashes: memory at address zero"};
    default:
      return {ChildEnd::crashed, "reading it ends early"};
  }
}

}  // namespace

ChildReport run_in_child(const std::function<void(const Sink&)>& task,
                         const std::function<void(const Source&)>& take, const ChildLimits& limits) {
  Pipe data, words;
  ChildLimits all = limits;
  const auto mapped = mapped_memory();
  all.bytes = mapped ? *mapped + limits.bytes : RLIM_INFINITY;
  if (!data.good || !words.good) throw std::bad_alloc();
  const pid_t pid = ::fork();
  if (pid < 0) throw std::bad_alloc();  // memory, or processes, which are as short then
  if (pid == 0) child(task, all, data.out(), words.out());
  data.close(1);
  words.close(1);
  std::exception_ptr thrown;
  bool whole = true;
  try {
    take([&](void* to, std::size_t size) {
      if (read_up_to(data.in(), static_cast<char*>(to), size) < size) throw EndOfChild();
    });
  } catch (const EndOfChild&) {
    whole = false;
  } catch (...) {
    thrown = std::current_exception();
    ::kill(pid, SIGKILL);
  }
  data.close(0);
  char text[kLongestText];
  const std::size_t length = read_up_to(words.in(), text, sizeof text);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  if (thrown) std::rethrow_exception(thrown);
  ChildReport report = report_of(status, {text, length});
  if (report.end == ChildEnd::done && !whole) report = {ChildEnd::crashed, "reading it ends early"};
  return report;
}

}  // namespace splinevox
