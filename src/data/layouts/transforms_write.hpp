// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "splinevox/core/camera.hpp"

/// Fields of transforms files, as programs that read them expect them.
namespace splinevox::data {

/// The lens of a camera.
nlohmann::ordered_json lens_json(const Camera& camera);
/// A camera-to-world matrix, its position shifted and then scaled.
nlohmann::ordered_json matrix_json(const std::array<double, 16>& matrix, const Vec3d& shift = {},
                                   double scale = 1);

}  // namespace splinevox::data
