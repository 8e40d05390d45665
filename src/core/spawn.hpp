// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace splinevox {

/// What stands for a descriptor: this process's own, or the null device.
constexpr int kInherited = -1, kNothing = -2;

/// A program to start, and where its three streams lead.
struct Spawn {
  std::string program;                        ///< a path, or a name that PATH leads to
  std::vector<std::string> words;             ///< its own name and its arguments
  int input = kNothing, output = kInherited;  ///< descriptors of this process
  int errors = kInherited;                    ///< may be that of the output
  std::vector<std::string> usual = {};        ///< NAME=VALUE of its environment, where NAME is not set yet
  bool own_group = false;                     ///< of processes: Ctrl-C in the terminal does not reach it
};

/// Starts it. @return its process; -1 with errno set if it cannot be started
pid_t spawn(const Spawn& start);
/// Waits for its end; whether it ended by itself, with status 0.
bool ended_well(pid_t process);

}  // namespace splinevox
