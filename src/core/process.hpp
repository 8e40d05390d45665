// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace splinevox {

/// Processor time of this process so far, all its threads together; seconds. Unlike wall time it does not
/// grow while others have the cores.
double processor_seconds();
/// That of the calling thread alone.
double thread_seconds();
/// The processor's name and how many threads it runs at once: "... @ 2.60GHz, 8 threads".
std::string machine_name();
/// How this process was started, as a shell takes it; empty where it cannot be told.
std::string command_line();

/// Memory that could be had now without pushing anything out to disk, bytes: what the machine, the container
/// (cgroup) and this process's own limit (ulimit -v) leave; 0 where it cannot be told.
double free_memory();
/// The most memory that this process could have by those three, bytes; 0 where it cannot be told.
double total_memory();
/// What this process may plan with where nobody says how much: four fifths of the most it could have, and no
/// more than is free; infinity where neither can be told.
double usable_memory();
/// The most memory this process has had in use at once, bytes.
double peak_memory();

/// Gives memory that was freed back to the system, where the C library can: what was a passing need would
/// otherwise count beside what comes after it.
void release_freed_memory();

}  // namespace splinevox
