// SPDX-License-Identifier: Apache-2.0
#include "core/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/handle.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

std::shared_ptr<const MappedFile> MappedFile::open(const std::string& path) {
  const Handle file(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  struct stat info {};
  if (!file.ok() || ::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0) return {};
  const std::size_t size(info.st_size);
  void* const place = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (place == MAP_FAILED)
    fail({path, "the file cannot be mapped", "room for its addresses", std::strerror(errno),
          errno == ENOMEM ? "raise the limit of addresses (ulimit -v)" : ""});
  return std::shared_ptr<const MappedFile>(new MappedFile({static_cast<const std::uint8_t*>(place), size}));
}

MappedFile::~MappedFile() { ::munmap(const_cast<std::uint8_t*>(bytes_.data()), bytes_.size()); }

void advise(const void* first, std::size_t bytes, Pages pages) {
  const auto page = std::uintptr_t(::sysconf(_SC_PAGESIZE)), end = std::uintptr_t(first) + bytes;
  const int advice = pages == Pages::soon ? MADV_WILLNEED : MADV_DONTNEED;
  // Of one call to read ahead, Linux takes no more than what the device reads at once.
  const std::uintptr_t most = pages == Pages::soon ? std::uintptr_t(1) << 17 : bytes + page;
  for (std::uintptr_t at = std::uintptr_t(first) / page * page; at < end; at += most)
    ::madvise(reinterpret_cast<void*>(at), std::min(most, end - at), advice);
}

}  // namespace splinevox
