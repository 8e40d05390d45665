// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <signal.h>
#include <stdio_ext.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/group_memory.hpp"
#include "core/system.hpp"

namespace splinevox {
namespace {

/// A figure of the machine's memory, bytes.
std::optional<double> meminfo(const char* name) {
  std::ifstream file("/proc/meminfo");
  for (std::string key; file >> key; file.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (double kilobytes = 0; key == name && file >> kilobytes) return 1024 * kilobytes;
  return {};
}

}  // namespace

std::optional<MachineMemory> machine_memory() {
  const auto most = meminfo("MemTotal:"), left = meminfo("MemAvailable:");
  if (!most || !left) return {};
  std::ostringstream membership;
  membership << std::ifstream("/proc/self/cgroup").rdbuf();
  const GroupMemory group = group_memory(membership.str(), "/sys/fs/cgroup");
  return MachineMemory{std::min(*most, group.most), std::min(*left, group.left)};
}

std::optional<std::uint64_t> mapped_memory() {
  std::uint64_t pages = 0;
  if (!(std::ifstream("/proc/self/statm") >> pages)) return {};
  return pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

double peak_memory_unit() { return 1024; }

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (const std::size_t colon = line.find(": "); line.starts_with("model name") && colon != line.npos)
      return line.substr(colon + 2);
  return "unknown processor";
}

std::vector<std::string> own_command() {
  std::vector<std::string> words;
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}
void name_own_program(const char*) {}
std::string own_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }
std::string own_program_again() {  // by its name as long as that leads to it: `top` shows it
  constexpr const char* kRunning = "/proc/self/exe";
  std::error_code gone;
  const std::string path = own_program();
  return std::filesystem::equivalent(path, kRunning, gone) ? path : kRunning;
}

void use_large_pages(void* first, std::size_t bytes) { ::madvise(first, bytes, MADV_HUGEPAGE); }

bool make_pipe(int (&ends)[2]) { return ::pipe2(ends, O_CLOEXEC) == 0; }

bool fill_random(void* to, std::size_t size) { return ::getrandom(to, size, 0) == ssize_t(size); }

void drop_unwritten(std::FILE* stream) { ::__fpurge(stream); }

void end_with_parent() { ::prctl(PR_SET_PDEATHSIG, SIGKILL); }

}  // namespace splinevox
