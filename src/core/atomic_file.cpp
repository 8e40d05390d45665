// SPDX-License-Identifier: Apache-2.0
#include "core/atomic_file.hpp"

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
#include <optional>
#include <utility>
#include <vector>

#include "core/hash.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

/// A file descriptor that closes itself.
class Handle {
 public:
  Handle(const std::string& path, int flags, mode_t mode = 0666) {
    do fd_ = ::open(path.c_str(), flags | O_CLOEXEC, mode);
    while (fd_ < 0 && errno == EINTR);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { close(); }
  int get() const { return fd_; }
  bool ok() const { return fd_ >= 0; }
  bool close() {
    const int fd = fd_;
    fd_ = -1;
    return fd < 0 || ::close(fd) == 0;
  }

 private:
  int fd_ = -1;
};

/// Turns a file size limit into an error code of write() for this thread; by default it kills the process.
class SizeSignalBlocked {
 public:
  SizeSignalBlocked() {
    sigemptyset(&only_);
    sigaddset(&only_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &only_, &before_);
  }
  ~SizeSignalBlocked() {
    const int reason = errno;
    if (!sigismember(&before_, SIGXFSZ)) {
      const timespec now{};
      while (sigtimedwait(&only_, nullptr, &now) == SIGXFSZ) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    errno = reason;
  }
  SizeSignalBlocked(const SizeSignalBlocked&) = delete;
  SizeSignalBlocked& operator=(const SizeSignalBlocked&) = delete;

 private:
  sigset_t only_{}, before_{};
};

bool write_all(int fd, std::string_view bytes) {
  const SizeSignalBlocked blocked;
  while (!bytes.empty()) {
    // Linux writes at most 2^31 - 4096 bytes per call.
    const ssize_t n = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), std::size_t(1) << 30));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = ENOSPC;
    if (n <= 0) return false;
    bytes.remove_prefix(std::size_t(n));
  }
  return true;
}

std::string hint_for(int reason) {
  if (reason == ENOSPC || reason == EDQUOT) return "free space on this disk, or choose another output folder";
  if (reason == EFBIG) return "raise the file size limit (ulimit -f)";
  if (reason == ENOENT) return "create the folder first";
  if (reason == EACCES || reason == EPERM || reason == EROFS) return "choose a folder that you may write to";
  return "";
}

[[noreturn]] void fail_write(const std::string& path, int reason, std::uint64_t bytes) {
  fail_output({.where = path,
               .what = "could not be written",
               .expected = "room and permission for " + std::to_string(bytes) + " bytes",
               .got = std::strerror(reason),
               .hint = hint_for(reason)});
}

[[noreturn]] void fail_read(const std::string& path, int reason) {
  fail({.where = path, .what = "could not be read", .got = std::strerror(reason)});
}

/// Gives `path` the second name `previous`, replacing what had it; falls back to a move where links are not
/// supported.
bool keep_previous(const std::string& path, const std::string& previous) {
  const std::string link = previous + ".tmp";
  ::unlink(link.c_str());
  if (::link(path.c_str(), link.c_str()) == 0) return ::rename(link.c_str(), previous.c_str()) == 0;
  if (errno == ENOENT) return true;
  return ::rename(path.c_str(), previous.c_str()) == 0;
}

bool sync_folder(const std::string& path) {
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  const Handle folder(parent.empty() ? "." : parent.string(), O_RDONLY | O_DIRECTORY);
  // Some file systems refuse fsync on a folder (EINVAL); they order renames themselves.
  return folder.ok() && (::fsync(folder.get()) == 0 || errno == EINVAL);
}

template <class Piece>
void read_pieces(const std::string& path, std::uint64_t max_bytes, const Piece& piece) {
  Handle file(path, O_RDONLY);
  struct stat info {};
  if (!file.ok() || ::fstat(file.get(), &info) != 0) fail_read(path, errno);
  if (S_ISDIR(info.st_mode)) fail_read(path, EISDIR);
  if (std::uint64_t(info.st_size) > max_bytes)
    fail({.where = path,
          .what = "is too large",
          .expected = "at most " + std::to_string(max_bytes) + " bytes",
          .got = std::to_string(info.st_size) + " bytes"});
  std::vector<char> buffer(std::size_t(1) << 16);
  std::uint64_t total = 0;
  for (;;) {
    const ssize_t n = ::read(file.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_read(path, errno);
    if (n == 0) return;
    total += std::uint64_t(n);
    if (total > max_bytes) fail({.where = path, .what = "grew while it was read"});
    piece(std::string_view(buffer.data(), std::size_t(n)), std::uint64_t(info.st_size));
  }
}

}  // namespace

struct FileWriter::State {
  std::string path, target, temporary;  ///< temporary: beside the target; empty: a device or pipe, which
                                        ///< there is nothing to rename to
  std::uint64_t expected = 0;
  FileDigest digest;
  Hash64 hash;
  std::optional<Handle> file;

  [[noreturn]] void fail(int reason) { fail_write(path, reason, std::max(expected, digest.size)); }
};

FileWriter::FileWriter(const std::string& path, std::uint64_t bytes) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.path = s.target = path;
  s.expected = bytes;
  struct stat info {};
  mode_t mode = 0666;
  if (::stat(path.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) s.fail(EISDIR);
    if (!S_ISREG(info.st_mode)) {
      s.file.emplace(path, O_WRONLY);
      if (!s.file->ok()) s.fail(errno);
      return;
    }
    mode = info.st_mode & 0777;
    std::error_code ignored;
    const auto real =
        std::filesystem::canonical(path, ignored);  // keep a link a link: replace what it points to
    if (!ignored) s.target = real.string();
  }
  static std::atomic<unsigned> counter{0};
  std::string temporary =
      s.target + "." + std::to_string(::getpid()) + "-" + std::to_string(counter.fetch_add(1)) + ".tmp";
  s.file.emplace(temporary, O_WRONLY | O_CREAT | O_EXCL, mode);
  if (!s.file->ok()) s.fail(errno);
  s.temporary = std::move(temporary);
}

FileWriter::~FileWriter() {
  if (!state_->temporary.empty()) ::unlink(state_->temporary.c_str());
}

void FileWriter::add(std::string_view part) {
  State& s = *state_;
  s.hash.add(part);
  s.digest.size += part.size();
  if (!write_all(s.file->get(), part)) s.fail(errno);
}

FileDigest FileWriter::commit(const std::string& previous) {
  State& s = *state_;
  s.digest.hash = s.hash.value();
  if (s.temporary.empty()) {
    if (!s.file->close()) s.fail(errno);
    return s.digest;
  }
  bool ok = ::fsync(s.file->get()) == 0;
  ok = ok && s.file->close();
  ok = ok && (previous.empty() || keep_previous(s.target, previous));
  ok = ok && ::rename(s.temporary.c_str(), s.target.c_str()) == 0;
  if (!ok) s.fail(errno);
  s.temporary.clear();
  if (!sync_folder(s.target)) s.fail(errno);
  return s.digest;
}

FileDigest write_file(const std::string& path, std::initializer_list<std::string_view> parts,
                      const std::string& previous) {
  FileWriter file(path, total_size({parts.begin(), parts.size()}));
  for (const std::string_view part : parts) file.add(part);
  return file.commit(previous);
}

std::uint64_t total_size(std::span<const std::string_view> parts) {
  std::uint64_t bytes = 0;
  for (const std::string_view part : parts) bytes += part.size();
  return bytes;
}

std::vector<char> joined(std::span<const std::string_view> parts) {
  std::vector<char> out;
  out.reserve(total_size(parts));
  for (const std::string_view part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

std::string read_file(const std::string& path, std::uint64_t max_bytes) {
  std::string bytes;
  read_pieces(path, max_bytes, [&](std::string_view piece, std::uint64_t size) {
    bytes.reserve(std::size_t(size));
    bytes.append(piece);
  });
  return bytes;
}

FileDigest digest_file(const std::string& path) {
  FileDigest digest;
  Hash64 hash;
  read_pieces(path, ~std::uint64_t(0), [&](std::string_view piece, std::uint64_t) {
    hash.add(piece);
    digest.size += piece.size();
  });
  digest.hash = hash.value();
  return digest;
}

}  // namespace splinevox
