// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// Notes on lenses that are hardly real, and on focal lengths that the data gives twice and differently: one
/// note per kind, with the number of frames. @param split  the cameras that were made of `raw`
void note_lenses(const RawSplit& raw, const Split& split, std::vector<std::string>& notes);

}  // namespace splinevox::data
