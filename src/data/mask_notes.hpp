// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/layouts/read_scene.hpp"
#include "data/pictures/pictures.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// What to try where masks are meant the other way round: "--masks ignore-white". @param keeps_black  what is
/// kept now
std::string opposite_masks(const MaskUse& use, bool keeps_black);

/// Says what masks there are, what is taken of them and how else it could be; nothing of a set without any.
/// Reads some of them. Throws Error (Fault::input) where masks are used and those that were read are bad, or
/// leave nothing.
std::optional<DatasetMasks> note_masks(const OpenScene& open, const std::vector<PicturePlan>& plans,
                                       std::vector<std::string>& notes);

}  // namespace splinevox::data
