// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::run {

/// A true picture and where it was taken from.
struct TrueShot {
  std::string name;
  Camera camera;          ///< of the picture as it is here
  double time = 0;        ///< the model's, in [0, 1]
  std::vector<char> png;  ///< the truth over a background
};

/// A frame, no wider or higher than `size` pixels. @param background  linear colour
TrueShot true_shot(const Frame& frame, const Vec3& background, int size);
/// `count` frames of a split at most, evenly spaced in time and in its order.
std::vector<TrueShot> true_shots(const Split& split, const Vec3& background, int count, int size);

}  // namespace splinevox::run
