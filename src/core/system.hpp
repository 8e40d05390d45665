// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

namespace splinevox {

// What systems do each in a way of their own. system_linux.cpp has Linux's, system_posix.cpp what is left
// without it (SPLINEVOX_PORTABLE).

struct MachineMemory {
  double most = 0;  ///< bytes that all processes of this container or machine may have together
  double left = 0;  ///< of them, those that could be had now without pushing anything out to disk
};
/// Nothing where it cannot be told.
std::optional<MachineMemory> machine_memory();
/// Bytes of address space that this process has; nothing where it cannot be told.
std::optional<std::uint64_t> mapped_memory();
/// The unit of rusage's ru_maxrss, bytes.
double peak_memory_unit();

/// What the machine's processor calls itself; "unknown processor" where it cannot be told.
std::string processor_name();

/// The words of the command that started this process; none where they cannot be told.
std::vector<std::string> own_command();
/// @param first_word  of this program's command line, for systems that do not keep where a program lies
void name_own_program(const char* first_word);
/// The program that this process runs: a path, or a name to look for as the shell does. Throws Error
/// (Fault::output) where neither the system nor name_own_program said it.
std::string own_program();
/// What starts the very same program again. On Linux this is the file that runs, also after another one has
/// taken its place. Throws as own_program.
std::string own_program_again();

/// Asks that addresses be backed by pages of kLargePage bytes, where the system has such.
/// @pre `first` is a multiple of kLargePage
void use_large_pages(void* first, std::size_t bytes);
inline constexpr std::size_t kLargePage = std::size_t(1) << 21;

/// A pipe that no program started from here inherits. @return false: there is none, see errno
bool make_pipe(int (&ends)[2]);
/// Bytes that nobody can guess. @return false: the system has none
bool fill_random(void* to, std::size_t size);
/// Drops what was printed and could not be written yet, where the C library can: else it is tried again.
void drop_unwritten(std::FILE* stream);
/// Kills this process when the one that forked it ends, where the system can.
void end_with_parent();

/// When a file was last written.
inline const timespec& changed_at(const struct stat& info) {
#ifdef __APPLE__
  return info.st_mtimespec;
#else
  return info.st_mtim;
#endif
}

}  // namespace splinevox
