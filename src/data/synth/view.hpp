// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/pictures/exr.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox::data {

inline constexpr double kCameraAngle =
    0.6911112070083618;  ///< full horizontal field of view, radians, as D-NeRF's

/// One picture to make.
struct SynthShot {
  std::string split, name;
  double time = 0;
  Camera camera;
};

/// All pictures of a data set in order: train, val, test. Throws Error for an option out of range.
std::vector<SynthShot> plan_shots(const SynthOptions& options);

/// The picture with soft edges: straight RGBA, 4 channels in [0, 1], rounded to multiples of 1/255.
/// @param opaque  before a grey wall, alpha 1 everywhere.
Image draw(const SynthMoment& moment, const Camera& camera, bool opaque);

/// The layers of a truth file: one ray through each pixel's centre.
std::vector<ExrLayer> draw_truth(const SynthMoment& moment, const Camera& camera);

}  // namespace splinevox::data
