// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/has_matter.hpp"
#include "render/motion_loss.hpp"

namespace splinevox {

/// What training asks of every ray.
struct RayLosses {
  float stop = 0, min_weight = 0;  ///< as SamplingConfig
  float visible_share = 1;         ///< of LearnedRows::visible
  float faintest = kHalfLevel;  ///< difference from the background that counts as matter: has_matter. In the
                                ///< unit of brightness of the scene
  float transmittance = 0;      ///< weight of transmittance_prior
  MotionLoss<float> motion;
  float depth = 0;        ///< weight of depth_error; 0: no depth is asked for
  float tracks = 0;       ///< weight of track_error; 0: nothing is asked of tracks
  float track_scale = 0;  ///< 1 / longest edge of the box, 1 / scene unit
  std::uint64_t probe_seed = 0;
};

}  // namespace splinevox
