// SPDX-License-Identifier: Apache-2.0
#include "run/made_with.hpp"

#include <fmt/format.h>

#include <thread>

#include "core/process.hpp"

namespace splinevox::run {

std::string source_commit() {
  return
#include "run/commit.inc"
      ;
}

std::string machine_name() {
  return fmt::format("{}, {} cores", processor_name(), std::thread::hardware_concurrency());
}

}  // namespace splinevox::run
