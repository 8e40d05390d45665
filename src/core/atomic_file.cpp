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

#include "core/handle.hpp"
#include "core/hash.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

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
      sigset_t waiting{};
      int taken = 0;
      if (sigpending(&waiting) == 0 && sigismember(&waiting, SIGXFSZ)) sigwait(&only_, &taken);
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    errno = reason;
  }
  SizeSignalBlocked(const SizeSignalBlocked&) = delete;
  SizeSignalBlocked& operator=(const SizeSignalBlocked&) = delete;

 private:
  sigset_t only_{}, before_{};
};

std::string hint_for(int reason) {
  if (reason == ENOSPC || reason == EDQUOT) return "free space on this disk, or choose another output folder";
  if (reason == EFBIG) return "raise the file size limit (ulimit -f)";
  if (reason == ENOENT) return "create the folder first";
  if (reason == ELOOP) return "remove the link, or choose another name";
  if (reason == EACCES || reason == EPERM || reason == EROFS) return "choose a folder that you may write to";
  return "";
}

/// The system's words say something else of what is in the place of a file.
std::string reason_text(int reason) {
  if (reason == ELOOP) return "a link, and it is not followed";
  if (reason == ENXIO) return "a pipe or a device, where a file belongs";
  return std::strerror(reason);
}

[[noreturn]] void fail_write(const std::string& path, int reason, std::uint64_t bytes) {
  fail_output({.where = path,
               .what = "could not be written",
               .expected = "room and permission for " + std::to_string(bytes) + " bytes",
               .got = reason_text(reason),
               .hint = hint_for(reason)});
}

[[noreturn]] void fail_read(const std::string& path, int reason) {
  fail({.where = path, .what = "could not be read", .got = reason_text(reason)});
}

/// Gives `name` in a folder the second name `previous`, replacing what had it; falls back to a move where
/// links are not supported.
bool keep_previous(int folder, const std::string& name, const std::string& previous) {
  const std::string link = previous + ".tmp";
  ::unlinkat(folder, link.c_str(), 0);
  if (::linkat(folder, name.c_str(), folder, link.c_str(), 0) == 0) {
    if (::renameat(folder, link.c_str(), folder, previous.c_str()) == 0) {
      ::unlinkat(folder, link.c_str(), 0);  // still there where both were names of one file already
      return true;
    }
    const int reason = errno;
    ::unlinkat(folder, link.c_str(), 0);
    errno = reason;
    return false;
  }
  if (errno == ENOENT) return true;
  return ::renameat(folder, name.c_str(), folder, previous.c_str()) == 0;
}

bool sync(int fd) {
  return retried([&] { return ::fsync(fd); }) == 0;
}

template <class Piece>
void read_pieces(const std::string& path, std::uint64_t max_bytes, Named named, const Piece& piece) {
  const bool own = named == Named::by_program;
  Handle file(path, O_RDONLY | (own ? O_NOFOLLOW | O_NONBLOCK : 0));  // to open a pipe may take for ever
  struct stat info {};
  if (!file.ok() || ::fstat(file.get(), &info) != 0) fail_read(path, errno);
  if (S_ISDIR(info.st_mode)) fail_read(path, EISDIR);
  if (own && !S_ISREG(info.st_mode))
    fail({.where = path, .what = "is no file", .expected = "a regular file", .got = "a pipe or a device"});
  if (std::uint64_t(info.st_size) > max_bytes)
    fail({.where = path,
          .what = "is too large",
          .expected = "at most " + std::to_string(max_bytes) + " bytes",
          .got = std::to_string(info.st_size) + " bytes"});
  std::vector<char> buffer(std::size_t(1) << 16);
  std::uint64_t total = 0;
  for (;;) {
    const ssize_t n = retried([&] { return ::read(file.get(), buffer.data(), buffer.size()); });
    if (n < 0) fail_read(path, errno);
    if (n == 0) return;
    total += std::uint64_t(n);
    if (total > max_bytes) fail({.where = path, .what = "grew while it was read"});
    piece(std::string_view(buffer.data(), std::size_t(n)), std::uint64_t(info.st_size));
  }
}

}  // namespace

bool write_all(int fd, std::string_view bytes) {
  const SizeSignalBlocked blocked;
  while (!bytes.empty()) {
    // Linux writes at most 2^31 - 4096 bytes per call.
    const std::size_t part = std::min<std::size_t>(bytes.size(), std::size_t(1) << 30);
    const ssize_t n = retried([&] { return ::write(fd, bytes.data(), part); });
    if (n == 0) errno = ENOSPC;
    if (n <= 0) return false;
    bytes.remove_prefix(std::size_t(n));
  }
  return true;
}

struct FileWriter::State {
  std::string path;  ///< as messages show it
  std::string name,
      draft;  ///< in the folder; no draft: a device or pipe, which there is nothing to rename to
  std::uint64_t expected = 0;
  FileDigest digest;
  Hash64 hash;
  std::optional<Handle> folder, file;

  [[noreturn]] void fail(int reason) { fail_write(path, reason, std::max(expected, digest.size)); }
  void open_draft(mode_t mode);
};

/// Beside the target, under a name that nothing has.
void FileWriter::State::open_draft(mode_t mode) {
  static std::atomic<unsigned> counter{0};
  constexpr int kTries = 100;
  for (int i = 0; i < kTries && (!file || (!file->ok() && errno == EEXIST)); ++i) {
    draft = name + "." + std::to_string(::getpid()) + "-" + std::to_string(counter.fetch_add(1)) + ".tmp";
    file.emplace(folder->get(), draft, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, mode);
  }
  if (file->ok()) return;
  const int reason = errno;
  draft.clear();
  fail(reason);
}

FileWriter::FileWriter(const std::string& path, std::uint64_t bytes, Named named)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.path = path;
  s.expected = bytes;
  std::filesystem::path target = path;
  struct stat info {};
  if (named == Named::by_user && ::stat(path.c_str(), &info) == 0) {
    if (!S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)) {
      s.file.emplace(path, O_WRONLY);
      if (!s.file->ok()) s.fail(errno);
      return;
    }
    std::error_code no_such;  // keep a link a link: replace what it points to
    if (const auto real = std::filesystem::canonical(path, no_such); !no_such) target = real;
  }
  const std::string parent = target.parent_path().string();
  s.name = target.filename().string();
  s.folder.emplace(parent.empty() ? "." : parent, O_RDONLY | O_DIRECTORY);
  if (!s.folder->ok()) s.fail(errno);
  mode_t mode = 0666;
  if (::fstatat(s.folder->get(), s.name.c_str(), &info, AT_SYMLINK_NOFOLLOW) == 0) {
    if (S_ISDIR(info.st_mode)) s.fail(EISDIR);
    if (S_ISLNK(info.st_mode)) s.fail(ELOOP);
    if (!S_ISREG(info.st_mode)) s.fail(ENXIO);
    mode = info.st_mode & 0777;
  }
  s.open_draft(mode);
}

FileWriter::~FileWriter() {
  if (!state_->draft.empty()) ::unlinkat(state_->folder->get(), state_->draft.c_str(), 0);
}

void FileWriter::add(std::string_view part) {
  State& s = *state_;
  s.hash.add(part);
  s.digest.size += part.size();
  if (!write_all(s.file->get(), part)) s.fail(errno);
}

FileDigest FileWriter::commit(const std::string& previous, Wait wait) {
  State& s = *state_;
  s.digest.hash = s.hash.value();
  if (s.draft.empty()) {
    if (!s.file->close()) s.fail(errno);
    return s.digest;
  }
  const int folder = s.folder->get();
  bool ok = wait == Wait::no || sync(s.file->get());
  ok = ok && s.file->close();
  ok = ok && (previous.empty() || keep_previous(folder, s.name, previous));
  ok = ok && ::renameat(folder, s.draft.c_str(), folder, s.name.c_str()) == 0;
  if (!ok) s.fail(errno);
  s.draft.clear();
  // Some file systems refuse fsync on a folder (EINVAL); they order renames themselves.
  if (wait == Wait::for_disk && !sync(folder) && errno != EINVAL) s.fail(errno);
  return s.digest;
}

FileDigest write_file(const std::string& path, std::initializer_list<std::string_view> parts, Named named) {
  FileWriter file(path, total_size({parts.begin(), parts.size()}), named);
  for (const std::string_view part : parts) file.add(part);
  return file.commit();
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

std::string read_file(const std::string& path, std::uint64_t max_bytes, Named named) {
  std::string bytes;
  read_pieces(path, max_bytes, named, [&](std::string_view piece, std::uint64_t size) {
    bytes.reserve(std::size_t(size));
    bytes.append(piece);
  });
  return bytes;
}

FileDigest digest_file(const std::string& path) {
  FileDigest digest;
  Hash64 hash;
  read_pieces(path, ~std::uint64_t(0), Named::by_program, [&](std::string_view piece, std::uint64_t) {
    hash.add(piece);
    digest.size += piece.size();
  });
  digest.hash = hash.value();
  return digest;
}

}  // namespace splinevox
