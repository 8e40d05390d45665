// SPDX-License-Identifier: Apache-2.0
// A library to preload: one call of the C library fails, the n-th after main has begun. What SPLINEVOX_FAIL
// says: "CALL N ERRNO HOW", such as "malloc 120 12 once" or "write 3 28 on" (from the third on). The calls
// are counted by kind in the file SPLINEVOX_COUNT, if there is one, when the program ends.
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

enum Call { kMalloc, kWrite, kRead, kOpen, kFsync, kRename, kMmap, kFork, kPipe, kCalls };
constexpr const char* kNames[kCalls] = {"malloc", "write", "read", "open", "fsync",
                                        "rename", "mmap",  "fork", "pipe"};

std::atomic<bool> running{false};
std::atomic<long> counts[kCalls];
int failing = -1, reason = 0;
long nth = 0;
bool from_there_on = false;

bool fails(Call call) {
  if (!running.load(std::memory_order_relaxed)) return false;
  const long n = ++counts[call];
  if (call != failing || !(from_there_on ? n >= nth : n == nth)) return false;
  errno = reason;
  return true;
}

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

void read_wish() {
  const char* wish = ::getenv("SPLINEVOX_FAIL");
  char call[16] = "", how[8] = "";
  if (!wish || std::sscanf(wish, "%15s %ld %d %7s", call, &nth, &reason, how) != 4) return;
  from_there_on = std::strcmp(how, "on") == 0;
  for (int c = 0; c < kCalls; ++c)
    if (std::strcmp(call, kNames[c]) == 0) failing = c;
}

void tell_counts() {
  running = false;
  const char* path = ::getenv("SPLINEVOX_COUNT");
  const int fd = path ? ::open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600) : -1;
  if (fd < 0) return;
  for (int c = 0; c < kCalls; ++c) ::dprintf(fd, "%s %ld\n", kNames[c], counts[c].load());
  ::close(fd);
}

using Main = int (*)(int, char**, char**);
Main real_main;

int counted_main(int argc, char** argv, char** env) {
  read_wish();
  running = true;
  const int code = real_main(argc, argv, env);
  tell_counts();
  return code;
}

}  // namespace

extern "C" {

int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(), void (*ld)(),
                      void* end) {
  using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  real_main = main;
  return real<Start>("__libc_start_main")(counted_main, argc, argv, init, fini, ld, end);
}

void* malloc(size_t size) { return fails(kMalloc) ? nullptr : __libc_malloc(size); }
void* calloc(size_t n, size_t size) { return fails(kMalloc) ? nullptr : __libc_calloc(n, size); }
void* realloc(void* p, size_t size) { return fails(kMalloc) ? nullptr : __libc_realloc(p, size); }
void* memalign(size_t align, size_t size) { return fails(kMalloc) ? nullptr : __libc_memalign(align, size); }
void* aligned_alloc(size_t align, size_t size) { return memalign(align, size); }
int posix_memalign(void** out, size_t align, size_t size) {
  void* p = memalign(align, size);
  if (!p) return ENOMEM;
  *out = p;
  return 0;
}

ssize_t write(int fd, const void* from, size_t size) {
  static const auto next = real<ssize_t (*)(int, const void*, size_t)>("write");
  return fails(kWrite) ? -1 : next(fd, from, size);
}
ssize_t read(int fd, void* to, size_t size) {
  static const auto next = real<ssize_t (*)(int, void*, size_t)>("read");
  return fails(kRead) ? -1 : next(fd, to, size);
}
int openat(int folder, const char* path, int flags, ...) {
  static const auto next = real<int (*)(int, const char*, int, mode_t)>("openat");
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return fails(kOpen) ? -1 : next(folder, path, flags, mode);
}
int fsync(int fd) {
  static const auto next = real<int (*)(int)>("fsync");
  return fails(kFsync) ? -1 : next(fd);
}
int renameat(int from, const char* a, int to, const char* b) {
  static const auto next = real<int (*)(int, const char*, int, const char*)>("renameat");
  return fails(kRename) ? -1 : next(from, a, to, b);
}
void* mmap(void* at, size_t size, int rights, int flags, int fd, off_t from) {
  static const auto next = real<void* (*)(void*, size_t, int, int, int, off_t)>("mmap");
  return fails(kMmap) ? MAP_FAILED : next(at, size, rights, flags, fd, from);
}
pid_t fork() {
  static const auto next = real<pid_t (*)()>("fork");
  return fails(kFork) ? -1 : next();
}
int pipe2(int ends[2], int flags) {
  static const auto next = real<int (*)(int[2], int)>("pipe2");
  return fails(kPipe) ? -1 : next(ends, flags);
}

}  // extern "C"
