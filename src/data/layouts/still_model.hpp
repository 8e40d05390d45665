// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Cameras that stand still beside what they took: a model of one moment, with one picture of every camera,
/// and a film or a folder of two pictures or more for each. A camera's name is its frame's own, else that of
/// its picture (images/cam00.png) or of the picture's folder (cam00/0000.png). Its frame becomes one for
/// every picture that it took, as take_footage does.
///
/// @return whether that is what lies in the folder; if not, the scene is as it was. Throws Error
/// (Fault::input).
bool take_still_model(const std::filesystem::path& folder, RawScene& scene);

}  // namespace splinevox::data
