// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace splinevox {

/// How a task in a child process ended.
enum class ChildEnd {
  done,
  refused,    ///< it threw; the text is that of its exception
  no_memory,  ///< it, or the machine, ran out of memory
  null,       ///< it used memory at address zero, as libraries do that do not check what they were given
  crashed     ///< any other signal, or more time than it may take
};
struct ChildReport {
  ChildEnd end = ChildEnd::done;
  std::string text{};
};

struct ChildLimits {
  unsigned seconds = 20;    ///< of processor time
  std::uint64_t bytes = 0;  ///< of memory beyond what the process has now
};

/// Takes so many bytes of a result.
using Sink = std::function<void(const void*, std::size_t)>;
/// Fills so many bytes, or throws because the child ended before.
using Source = std::function<void(void*, std::size_t)>;

/// Runs `task` in a forked copy of this process with limits and without rights (drop_rights), and `take`,
/// here, on what the task hands to its sink. For parsers of libraries that crash, hang or allocate without
/// end on damaged input: whatever a file makes of the child, it can only send bytes, which `take` must not
/// trust. Exceptions of `take` come out, once the child has ended.
/// @note    Only the calling thread exists in the child: the task must not need others.
ChildReport run_in_child(const std::function<void(const Sink&)>& task,
                         const std::function<void(const Source&)>& take, const ChildLimits& limits);

}  // namespace splinevox
