// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// The rays of a step and what they show, as a loss of the caller's own sees them. All are [rays], in a fixed
/// order; four rays in turn are of one block of 2 x 2 pixels. Colours are display values in the unit that the
/// scene is trained in (Prepared::brightness), without the gains of cameras.
struct RayBatch {
  /// A pixel of the train split: its frame, column and row. Frame -1: the ray asks for emptiness at another
  /// moment than its picture.
  struct Pixel {
    int frame, x, y;
  };
  std::vector<Pixel> pixels;
  std::vector<double> times;      ///< model time, [0, 1]
  std::vector<Vec3> origins;      ///< where each enters the box, scene units
  std::vector<Vec3> directions;   ///< of unit length
  std::vector<Vec3> colours;      ///< what the model shows, over the background
  std::vector<Vec3> targets;      ///< what the picture shows, over the background
  std::vector<Vec3> backgrounds;  ///< behind each; random unless it is learned or fixed
  std::vector<float> weights;     ///< of its photometric loss, 1 on the mean
  std::vector<Vec3> photometric;  ///< gradient of that loss, weight * (colour - target)^2, by the colour: 0
                                  ///< where a target that a picture clips is exceeded
};

/// Takes the place of the photometric loss. Fills d loss / d colour, [rays], of the loss summed over the
/// rays; it is 0 when this is called. @return the loss, summed too; none: reports keep the squared error's
using ColourLoss = std::function<std::optional<double>(const RayBatch& rays, std::span<Vec3> gradients)>;

}  // namespace splinevox
