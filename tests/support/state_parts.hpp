// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "train/archive.hpp"

namespace splinevox::test {

/// A section of a training state: bytes [first, first + size).
struct StatePart {
  std::size_t first, size;
};

/// The sections of what Trainer::save gave, by name.
inline std::map<std::string, StatePart> parts_of(const std::vector<char>& state) {
  std::map<std::string, StatePart> out;
  for (std::size_t at = 0; at < state.size();) {
    const std::string name(state.data() + at, strnlen(state.data() + at, Archive::kSectionName));
    std::uint64_t size;
    std::memcpy(&size, state.data() + at + Archive::kSectionName, sizeof size);
    at += Archive::kSectionName + sizeof size;
    out[name] = {at, std::size_t(size)};
    at += std::size_t(size);
  }
  return out;
}

/// The bytes of one of them.
inline std::vector<char> part(const std::vector<char>& state, const std::string& name) {
  const StatePart p = parts_of(state).at(name);
  return {state.begin() + std::ptrdiff_t(p.first), state.begin() + std::ptrdiff_t(p.first + p.size)};
}

/// All bytes but those of some sections, as text.
inline std::string without(const std::vector<char>& state, std::initializer_list<const char*> names) {
  std::map<std::string, StatePart> kept = parts_of(state);
  for (const char* name : names) kept.erase(name);
  std::string out;
  for (const auto& [name, p] : kept) out.append(state.data() + p.first, p.size);
  return out;
}

/// Whether two states are the same but for the readings of a clock.
inline bool same_parameters(const std::vector<char>& a, const std::vector<char>& b) {
  return without(a, {"clock"}) == without(b, {"clock"});
}

}  // namespace splinevox::test
