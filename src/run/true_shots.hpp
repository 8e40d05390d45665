// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
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
  std::vector<char> png;  ///< the truth
  bool clear = false;     ///< one can see through it: the PNG file has alpha
};

/// A frame, no wider or higher than `size` pixels.
/// @param background  that it is laid over, display values; none: it stays clear where it is
TrueShot true_shot(const Frame& frame, const std::optional<Vec3>& background, int size);
/// `count` frames of a split at most, evenly spaced in time and in its order.
std::vector<TrueShot> true_shots(const Split& split, const std::optional<Vec3>& background, int count,
                                 int size);

}  // namespace splinevox::run
