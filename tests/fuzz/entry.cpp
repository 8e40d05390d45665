// SPDX-License-Identifier: Apache-2.0
// libFuzzer's way in: SPLINEVOX_FUZZ_TARGET names the parser. What is not an input error ends the process,
// which is what it looks for.
#include <cstdlib>
#include <cstring>

#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const splinevox::fuzz::Target& target = []() -> const splinevox::fuzz::Target& {
    for (const splinevox::fuzz::Target& t : splinevox::fuzz::targets())
      if (std::strcmp(t.name, SPLINEVOX_FUZZ_TARGET) == 0) return t;
    std::abort();
  }();
  target.run(data, size);
  return 0;
}
