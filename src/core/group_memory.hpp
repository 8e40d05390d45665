// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

namespace splinevox {

/// What a group of processes (cgroup), as a container is one, leaves to each of them.
struct GroupMemory {
  double most = std::numeric_limits<double>::infinity();  ///< bytes all of them may have together
  double left = std::numeric_limits<double>::infinity();  ///< of them, not in use
};

/// The tightest of the groups that a process is in, of version 1 or 2.
/// @param membership  what /proc/self/cgroup says. @param root  where the groups' files are, /sys/fs/cgroup
GroupMemory group_memory(const std::string& membership, const std::string& root);

}  // namespace splinevox
