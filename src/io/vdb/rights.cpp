// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/rights.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

#if !SPLINEVOX_PORTABLE
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#if defined(__x86_64__)
#define SPLINEVOX_AUDIT_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define SPLINEVOX_AUDIT_ARCH AUDIT_ARCH_AARCH64
#endif
#endif

namespace splinevox {
namespace {

void close_others(std::initializer_list<int> kept) {
  std::vector<int> keep(kept);
  std::sort(keep.begin(), keep.end());
  const auto close_range = [](unsigned first, unsigned last) {
    if (first > last) return;
#ifdef SYS_close_range
    if (::syscall(SYS_close_range, first, last, 0) == 0) return;
#endif
    const auto most = unsigned(std::clamp(::sysconf(_SC_OPEN_MAX), 0L, 65536L));
    for (unsigned fd = first; fd <= std::min(last, most); ++fd) ::close(int(fd));
  };
  unsigned next = 0;
  for (const int fd : keep) {
    if (unsigned(fd) > next) close_range(next, unsigned(fd) - 1);
    next = unsigned(fd) + 1;
  }
  close_range(next, ~0u);
}

#ifdef SPLINEVOX_AUDIT_ARCH

constexpr int kAllowed[] = {SYS_read,
                            SYS_write,
                            SYS_readv,
                            SYS_writev,
                            SYS_lseek,
                            SYS_fstat,
                            SYS_close,
                            SYS_brk,
                            SYS_munmap,
                            SYS_mremap,
                            SYS_madvise,
                            SYS_futex,
                            SYS_sched_yield,
                            SYS_rt_sigaction,
                            SYS_rt_sigprocmask,
                            SYS_rt_sigreturn,
                            SYS_sigaltstack,
                            SYS_getpid,
                            SYS_gettid,
                            SYS_clock_gettime,
                            SYS_gettimeofday,
                            SYS_getrandom,
                            SYS_sysinfo,
                            SYS_getrusage,
                            SYS_sched_getaffinity,
                            SYS_restart_syscall,
                            SYS_exit,
                            SYS_exit_group};

bool filter_calls() {
  constexpr unsigned kNumber = offsetof(seccomp_data, nr), kArch = offsetof(seccomp_data, arch),
                     kFirst = offsetof(seccomp_data, args), kThird = kFirst + 2 * sizeof(std::uint64_t);
  constexpr unsigned kPass = SECCOMP_RET_ALLOW, kRefuse = SECCOMP_RET_ERRNO | EPERM;
  const auto load = [](unsigned at) { return sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, at); };
  const auto give = [](unsigned verdict) { return sock_filter BPF_STMT(BPF_RET | BPF_K, verdict); };
  const auto unless_equal = [](unsigned value, unsigned skip) {
    return sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, std::uint8_t(skip));
  };
  std::vector<sock_filter> code;
  code.push_back(load(kArch));
  code.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SPLINEVOX_AUDIT_ARCH, 1, 0));
  code.push_back(give(SECCOMP_RET_KILL_PROCESS));
  code.push_back(load(kNumber));
  for (const int call : kAllowed) {
    code.push_back(unless_equal(unsigned(call), 1));
    code.push_back(give(kPass));
  }
  for (const int call : {SYS_mmap, SYS_mprotect}) {  // memory, but none to run
    code.push_back(unless_equal(unsigned(call), 4));
    code.push_back(load(kThird));
    code.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1));
    code.push_back(give(kRefuse));
    code.push_back(give(kPass));
  }
  code.push_back(unless_equal(unsigned(SYS_tgkill), 3));  // abort() sends itself a signal
  code.push_back(load(kFirst));
  code.push_back(unless_equal(unsigned(::getpid()), 1));
  code.push_back(give(kPass));
  code.push_back(give(kRefuse));
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

#else

bool filter_calls() { return false; }

#endif

}  // namespace

bool drop_rights(std::initializer_list<int> kept) {
  close_others(kept);
  const rlimit none{0, 0};
  for (const auto limit : {RLIMIT_CORE, RLIMIT_FSIZE, RLIMIT_NOFILE}) ::setrlimit(limit, &none);
  return filter_calls();
}

}  // namespace splinevox
