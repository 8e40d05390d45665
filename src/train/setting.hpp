// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/start.hpp"
#include "train/still/still_cameras.hpp"

namespace splinevox {

/// What a run is given and never changes.
struct Setting {
  Setting(const Config& c, const Split& t)
      : stats(picture_stats(t)),
        unit(brightness(c, stats)),
        config(for_silhouettes(stats, for_thin(stats, for_places(stats, in_units_of(unit, c))))),
        train(t),
        still(asks_still_cameras(c) ? still_cameras(t, unit) : std::vector<StillCamera>()) {}

  const PictureStats stats;
  const float unit;     ///< of brightness; 1 unless the scene is dark
  const Config config;  ///< in that unit
  const Split& train;
  const std::vector<StillCamera> still;  ///< of the training frames, if asks_still_cameras
};

}  // namespace splinevox
