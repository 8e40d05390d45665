// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace splinevox {

/// A system call again for as long as a signal comes in between.
template <class Call>
auto retried(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

/// A file descriptor that closes itself.
class Handle {
 public:
  Handle(const std::string& path, int flags, mode_t mode = 0666) : Handle(AT_FDCWD, path, flags, mode) {}
  /// @param folder  descriptor of the folder that a relative name is looked up in
  Handle(int folder, const std::string& name, int flags, mode_t mode = 0666)
      : fd_(retried([&] { return ::openat(folder, name.c_str(), flags | O_CLOEXEC, mode); })) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { close(); }
  int get() const { return fd_; }
  bool ok() const { return fd_ >= 0; }
  bool close() {
    const int fd = fd_;
    fd_ = -1;
    return fd < 0 || ::close(fd) == 0 || errno == EINTR;  // Linux has closed it even then
  }

 private:
  int fd_ = -1;
};

}  // namespace splinevox
