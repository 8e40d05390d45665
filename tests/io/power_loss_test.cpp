// SPDX-License-Identifier: Apache-2.0
// F2: a power cut loses, reorders or tears what was not synchronised. The system calls of write_file are
// recorded (the linker wraps them), and every state that a disk may be in after any prefix of them is laid
// out and read.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <map>
#include <random>

#include "io/checkpoint.hpp"
#include "scratch.hpp"
#include "splinevox/core/error.hpp"

namespace {

/// One recorded call on the files of a folder. Names are those within it.
struct Call {
  enum Kind { create, write, sync_file, sync_folder, link, rename, unlink, returned } kind;
  int file = -1;         ///< which file: the order of creation
  std::string name, to;  ///< of the folder's entries
  std::string bytes{};
};

std::string recorded_folder;
std::vector<Call> calls;
std::map<int, int> file_of;  ///< descriptor -> file
int folder_descriptor = -1, files_made = 0;

bool inside(int folder) { return folder >= 0 && folder == folder_descriptor; }

}  // namespace

extern "C" {
int __real_openat(int, const char*, int, ...);
ssize_t __real_write(int, const void*, size_t);
int __real_fsync(int);
int __real_close(int);
int __real_linkat(int, const char*, int, const char*, int);
int __real_renameat(int, const char*, int, const char*);
int __real_unlinkat(int, const char*, int);

int __wrap_openat(int folder, const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int mode = flags & O_CREAT ? va_arg(rest, int) : 0;
  va_end(rest);
  const int fd = __real_openat(folder, path, flags, mode);
  if (fd >= 0 && (flags & O_CREAT) && inside(folder)) {
    file_of[fd] = files_made;
    calls.push_back({Call::create, files_made++, path, {}});
  }
  if (fd >= 0 && (flags & O_DIRECTORY) && !recorded_folder.empty() && recorded_folder == path)
    folder_descriptor = fd;
  return fd;
}
ssize_t __wrap_write(int fd, const void* data, size_t size) {
  const ssize_t n = __real_write(fd, data, size);
  if (n > 0 && file_of.count(fd))
    calls.push_back(
        {Call::write, file_of[fd], {}, {}, std::string(static_cast<const char*>(data), std::size_t(n))});
  return n;
}
int __wrap_fsync(int fd) {
  if (file_of.count(fd)) calls.push_back({Call::sync_file, file_of[fd], {}, {}});
  if (fd == folder_descriptor) calls.push_back({Call::sync_folder, -1, {}, {}});
  return __real_fsync(fd);
}
int __wrap_close(int fd) {
  file_of.erase(fd);
  if (fd == folder_descriptor) folder_descriptor = -1;
  return __real_close(fd);
}
int __wrap_linkat(int a, const char* from, int b, const char* to, int flags) {
  const int result = __real_linkat(a, from, b, to, flags);
  if (result == 0 && inside(a) && inside(b)) calls.push_back({Call::link, -1, from, to});
  return result;
}
int __wrap_renameat(int a, const char* from, int b, const char* to) {
  const int result = __real_renameat(a, from, b, to);
  if (result == 0 && inside(a) && inside(b)) calls.push_back({Call::rename, -1, from, to});
  return result;
}
int __wrap_unlinkat(int folder, const char* path, int flags) {
  const int result = __real_unlinkat(folder, path, flags);
  if (result == 0 && inside(folder)) calls.push_back({Call::unlink, -1, path, {}});
  return result;
}
}

namespace {

using namespace splinevox;
using namespace splinevox::test;

/// What is on the disk and what is only in memory, after some calls.
class Disk {
 public:
  void take(const Call& c) {
    switch (c.kind) {
      case Call::create:
        synced_.emplace_back();
        all_.emplace_back();
        change({c.name, c.file});
        break;
      case Call::write:
        all_[std::size_t(c.file)] += c.bytes;
        break;
      case Call::sync_file:
        synced_[std::size_t(c.file)] = all_[std::size_t(c.file)];
        break;
      case Call::sync_folder:
        names_ = now_;
        pending_.clear();
        break;
      case Call::link:
        change({c.to, now_.at(c.name)});
        break;
      case Call::rename:
        change({c.to, now_.at(c.name), c.name});
        break;
      case Call::unlink:
        change({"", -1, c.name});
        break;
      case Call::returned:
        break;
    }
  }

  /// One state that a cut at this moment may leave: changes of names that were not synchronised are there or
  /// not, each for itself; bytes that were not are there, missing from somewhere on, or zero.
  void lay_out(const std::string& folder, std::mt19937& random) const {
    std::map<std::string, int> names = names_;
    for (const Change& change : pending_)
      if (random() % 2) apply(change, names);
    for (const auto& [name, file] : names) {
      const std::string &synced = synced_[std::size_t(file)], &all = all_[std::size_t(file)];
      std::string bytes = all;
      if (all.size() > synced.size()) {
        const std::size_t from = synced.size() + random() % (all.size() - synced.size() + 1);
        if (random() % 2)
          bytes.resize(from);
        else
          std::fill(bytes.begin() + std::ptrdiff_t(from), bytes.end(), '\0');
      }
      spit(folder + "/" + name, bytes);
    }
  }

 private:
  struct Change {
    std::string name;  ///< gets the file; empty: none does
    int file;
    std::string gone{};  ///< loses it; empty: none does
  };
  static void apply(const Change& c, std::map<std::string, int>& names) {
    if (!c.gone.empty()) names.erase(c.gone);
    if (!c.name.empty()) names[c.name] = c.file;
  }
  void change(const Change& c) {
    apply(c, now_);
    pending_.push_back(c);
  }

  std::vector<std::string> synced_, all_;  ///< bytes of each file
  std::map<std::string, int> names_, now_;
  std::vector<Change> pending_;
};

}  // namespace

TEST_SUITE("io/power loss") {
  TEST_CASE(
      "F2: after a power cut at any moment the checkpoint is the last one written, or the one that was being "
      "written") {
    const Scratch written;
    recorded_folder = written.folder();
    constexpr int kGenerations = 12;
    for (int g = 1; g <= kGenerations; ++g) {
      CheckpointHeader header;
      header.step = std::uint64_t(g);
      header.kind = "trainer";
      write_checkpoint(written.path("checkpoint.bin"), header,
                       std::vector<char>(std::size_t(300 + 40 * g), char('a' + g)));
      calls.push_back({Call::returned, g, {}, {}});
    }
    recorded_folder.clear();
    REQUIRE(calls.size() > kGenerations * 8);

    std::mt19937 random(1);
    Disk disk;
    int states = 0, last = 0, unreadable = 0, older = 0, newest = 0;
    for (const Call& call : calls) {
      disk.take(call);
      if (call.kind == Call::returned) last = call.file;
      for (int variant = 0; variant < 100; ++variant, ++states) {
        const Scratch after;
        disk.lay_out(after.folder(), random);
        try {
          const std::uint64_t step = read_checkpoint(after.path("checkpoint.bin")).header.step;
          older += int(step) < last;
          newest = std::max(newest, int(step));
        } catch (const Error&) {
          unreadable += last > 0;  // before the first was written there may be none
        }
      }
    }
    MESSAGE(states << " states after a power cut");
    CHECK(states >= 10000);
    CHECK(unreadable == 0);
    CHECK(older == 0);
    CHECK(newest == kGenerations);
  }
}
