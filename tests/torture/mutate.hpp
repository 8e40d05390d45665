// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"

namespace splinevox::torture {

/// The index-th mutation of a target's seeds: bits flipped, bytes and machine numbers replaced, written
/// numbers replaced, parts cut out, repeated, truncated or taken from another seed. A function of its
/// arguments alone, on any machine and compiler.
std::string mutate(const fuzz::Target& target, const std::vector<std::string>& seeds, std::uint64_t seed,
                   std::uint64_t index);

}  // namespace splinevox::torture
