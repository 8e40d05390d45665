// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// A comparison of two fits on a part of each held-out picture.
struct GainsWhere {
  std::vector<double> gains;  ///< dB per picture that has enough pixels there
  double share = 0;           ///< of all pixels that were compared
};

/// @param where       of each held-out picture, one channel: 1 where it is compared, else 0
/// @param more, less  pictures of the two fits
/// @return none if hardly a picture has enough pixels there
std::optional<GainsWhere> gains_where(const std::vector<Image>& where, const std::vector<Frame>& held_out,
                                      const Vec3& background, const std::vector<Image>& more,
                                      const std::vector<Image>& less);

}  // namespace splinevox
