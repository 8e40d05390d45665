// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>

namespace splinevox {

/// Takes from this process, for good, what a parser does not need: files, network, other processes and new
/// programs. What is left is memory, the descriptors given, signals to itself and its end. Every other system
/// call fails with EPERM (seccomp; where the system has none, limits on files and descriptors alone remain).
/// No thread may run besides. @return false if the system call filter is not in force.
bool drop_rights(std::initializer_list<int> kept);

}  // namespace splinevox
