// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"
#include "data/pictures/decode.hpp"
#include "splinevox/data/scene.hpp"

/// What is odd about a split, and which it is, wherever its pictures came from.
namespace splinevox::data {

/// Notes matrices that were not quite rigid.
void note_cameras(const RawSplit& raw, std::vector<std::string>& notes);

/// Notes what the pictures of a split show. @param facts  of each; `black` is cleared where nothing is
/// visible
void note_facts(const Split& split, std::vector<PictureFacts>& facts, std::vector<std::string>& notes);

/// Over the numbers as written and the pixels as kept, so that it does not depend on this machine's rounding.
std::uint64_t fingerprint_of(const RawSplit& raw, const Split& split, const std::vector<PictureFacts>& facts);

}  // namespace splinevox::data
