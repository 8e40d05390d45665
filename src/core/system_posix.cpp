// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/system.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

std::string& program() {
  static std::string name;
  return name;
}

}  // namespace

std::optional<MachineMemory> machine_memory() { return {}; }
std::optional<std::uint64_t> mapped_memory() { return {}; }

double peak_memory_unit() {
#ifdef __APPLE__
  return 1;
#else
  return 1024;
#endif
}

std::string processor_name() { return "unknown processor"; }

std::vector<std::string> own_command() { return {}; }
void name_own_program(const char* first_word) {
  const std::string word = first_word;  // with a slash it is a path from the folder that we started in
  program() = word.find('/') == word.npos ? word : std::filesystem::absolute(word).string();
}

std::string own_program() {
  if (program().empty())
    fail_output(
        {"this program", "cannot start itself again", "the first word of its command line", "none", ""});
  return program();
}

std::string own_program_again() { return own_program(); }

void use_large_pages(void*, std::size_t) {}

bool make_pipe(int (&ends)[2]) {
  if (::pipe(ends) != 0) return false;
  for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  return true;
}

bool fill_random(void* to, std::size_t size) {
  std::ifstream source("/dev/urandom", std::ios::binary);
  return bool(source.read(static_cast<char*>(to), std::streamsize(size)));
}

void drop_unwritten(std::FILE*) {}
void end_with_parent() {}

}  // namespace splinevox
