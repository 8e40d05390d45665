// SPDX-License-Identifier: Apache-2.0
#include "run/made_with.hpp"

namespace splinevox::run {

std::string source_commit() {
  return
#include "run/commit.inc"
      ;
}

}  // namespace splinevox::run
