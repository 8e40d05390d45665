// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace splinevox {

/// Runs `task` in a forked copy of this process that may take `seconds` of time and `bytes` of memory beyond
/// what the process has now. For parsers of libraries that crash, hang or allocate without end on damaged
/// input.
/// @return  empty if the task ended, otherwise what stopped it: the text of its exception, or how it died.
/// @note    Only the calling thread exists in the child: the task must not need others.
std::string run_in_child(const std::function<void()>& task, unsigned seconds, std::uint64_t bytes);

}  // namespace splinevox
