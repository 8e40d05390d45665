// SPDX-License-Identifier: Apache-2.0
// libFuzzer's way in: SPLINEVOX_FUZZ_TARGET names the parser. What is not an input error ends the process, which is
// what it looks for.
#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  splinevox::fuzz::SPLINEVOX_FUZZ_TARGET(data, size);
  return 0;
}
