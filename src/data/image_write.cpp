// SPDX-License-Identifier: Apache-2.0
#include "splinevox/data/image_write.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "data/encode.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

[[noreturn]] void fail_write(const std::string& path, const char* doing, int error) {
  std::string hint;
  if (error == ENOSPC || error == EDQUOT) hint = "free some space, or write to another disk";
  if (error == EFBIG) hint = "raise the file size limit (ulimit -f)";
  if (error == EACCES || error == EPERM || error == EROFS) hint = "choose a folder you may write to";
  if (error == ENOENT) hint = "create the folder first";
  fail_output({.where = path,
               .what = std::string("cannot be written (") + doing + ")",
               .expected = {},
               .got = std::strerror(error),
               .hint = hint});
}

/// Turns a file size limit into an error code of write() for this thread; by default it kills the process.
class SizeSignalBlocked {
 public:
  SizeSignalBlocked() {
    sigemptyset(&only_);
    sigaddset(&only_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &only_, &before_);
  }
  ~SizeSignalBlocked() {
    if (!sigismember(&before_, SIGXFSZ)) {
      const timespec now{};
      while (sigtimedwait(&only_, nullptr, &now) == SIGXFSZ) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  SizeSignalBlocked(const SizeSignalBlocked&) = delete;
  SizeSignalBlocked& operator=(const SizeSignalBlocked&) = delete;

 private:
  sigset_t only_{}, before_{};
};

/// Writes all bytes and flushes them; returns 0 or the error, and what was being done.
int write_all(int file, std::span<const char> bytes, bool flush, const char*& doing) {
  doing = "writing";
  const SizeSignalBlocked blocked;
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), std::min<std::size_t>(bytes.size(), std::size_t(1) << 30));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) return ENOSPC;
    bytes = bytes.subspan(std::size_t(n));
  }
  doing = "flushing to disk";
  if (flush && ::fsync(file) != 0) return errno;
  return 0;
}

void write_in_place(const std::string& path, std::span<const char> bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) fail_write(path, "opening", errno);
  const char* doing = "";
  int error = write_all(file, bytes, false, doing);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) fail_write(path, doing, error);
}

}  // namespace

void write_file(const std::string& path, std::span<const char> bytes) {
  struct stat info {};
  std::string target = path;
  mode_t mode = 0644;
  if (::stat(path.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) fail_write(path, "opening", EISDIR);
    if (!S_ISREG(info.st_mode)) return write_in_place(path, bytes);
    mode = info.st_mode & 0777;
    std::error_code ignored;
    const auto real = std::filesystem::canonical(path, ignored);  // keep a link a link: replace what it points to
    if (!ignored) target = real.string();
  }
  static std::atomic<unsigned> counter{0};
  const std::string draft =
      target + "." + std::to_string(::getpid()) + "-" + std::to_string(counter.fetch_add(1)) + ".tmp";
  const int file = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0) fail_write(path, "creating", errno);
  const char* doing = "";
  int error = write_all(file, bytes, true, doing);
  if (::close(file) != 0 && error == 0) {
    error = errno;
    doing = "closing";
  }
  if (error == 0 && ::rename(draft.c_str(), target.c_str()) != 0) {
    error = errno;
    doing = "renaming the finished file";
  }
  if (error != 0) {
    ::unlink(draft.c_str());
    fail_write(path, doing, error);
  }
  const std::string folder = std::filesystem::path(target).parent_path().string();
  const int directory = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);  // best effort: some file systems cannot flush a folder, and the file itself is safe
    ::close(directory);
  }
}

std::vector<char> encode_png(const Image& image) { return encode_png_for("PNG picture", image); }

void write_png(const std::string& path, const Image& image) { write_file(path, encode_png_for(path, image)); }

void write_exr(const std::string& path, const std::vector<ExrLayer>& layers) {
  write_file(path, encode_exr_for(path, layers));
}

}  // namespace splinevox
