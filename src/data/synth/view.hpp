// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "data/pictures/exr.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox::data {

/// One picture to make.
struct SynthShot {
  std::string split, name;
  double time = 0;  ///< as the data says
  Camera camera;
  int camera_id = -1;   ///< of a rig, test cameras behind the others; -1: none
  double late = 0;      ///< how long after `time` the picture is taken
  Vec3d gain{1, 1, 1};  ///< of the exposure, per channel
};

/// Full horizontal field of view of every picture, radians.
double camera_angle(const SynthLook& look);

/// "cam03", as data sets name the cameras of a rig.
std::string synth_camera_name(int camera_id);

/// All pictures of a data set in order: train, val, test. Throws Error for an option out of range.
std::vector<SynthShot> plan_shots(const SynthOptions& options);

/// A picture with soft edges, values rounded to multiples of 1/255.
struct Drawn {
  Image picture;  ///< straight RGBA in [0, 1]
  Image mask;     ///< one channel: how much of the pixel is masked
};
/// Whether what a ray meets is in the mask. Gas always is, as far as it hides what is behind it.
using SynthMask = std::function<bool(const SynthHit&)>;
/// All but the room.
SynthMask subject_mask(const SynthMoment& moment);
/// What is somewhere else at some time of [0, 1].
SynthMask moving_mask(const SynthScene& scene);

/// @param opaque  before a grey wall, alpha 1 everywhere.
Drawn draw(const SynthMoment& moment, const Camera& camera, bool opaque, const Vec3d& gain,
           const SynthMask& mask);

/// Depth along the viewing axis by one ray through each pixel's centre, 0 where nothing solid is hit: the
/// numbers of a depth map of that kind. @param draw  of the picture's scale and shift
Image draw_depth(const SynthMoment& moment, const Camera& camera, DepthKind kind, std::uint64_t draw);

/// Points of surfaces that training pictures show, on a grid of each of a few of them, followed through all:
/// of each shot those that it shows; none of shots of other splits.
std::vector<std::vector<VisiblePoint>> follow_points(const SynthScene& scene,
                                                     const std::vector<SynthShot>& shots);

/// The layers of a truth file: one ray through each pixel's centre.
std::vector<ExrLayer> draw_truth(const SynthMoment& moment, const Camera& camera);

}  // namespace splinevox::data
