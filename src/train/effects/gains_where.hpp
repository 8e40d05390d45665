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

/// How far held-out pictures are brighter or darker than what a fit shows as a whole, and not in parts: of
/// the logarithms of the ratios in tiles of 8x8 pixels, the variance of the pictures' medians over that and
/// the mean variance within a picture, in [0, 1]. A tenth of a picture's tiles, the furthest from its median,
/// is left out: something may move there. An exposure acts on all of a picture; a highlight does not. 0 where
/// hardly a picture has enough tiles that show more than the background.
/// @param shown  pictures of the fit, without its gains. @param unit  of brightness (train/start.hpp)
double whole_share(const std::vector<Frame>& held_out, const Vec3& background,
                   const std::vector<Image>& shown, float unit);

/// How brightness differs between the pictures of a rig, by held-out ones and a fit without gains: standard
/// deviations of the logarithms of truth over shown. Of each picture and channel the median over tiles of 8x8
/// pixels counts, so what moves and is shown in a wrong place hardly does.
struct CameraSpread {
  double apart = 0;  ///< of the cameras, less what the pictures of one camera differ by; 0: it may be chance
  double drift = 0;  ///< of the pictures of one camera, less what their medians err by
};
/// Zeros where hardly a picture shows enough. @param shown  pictures of the fit
/// @param unit  of brightness
CameraSpread cameras_spread(const std::vector<Frame>& held_out, const Vec3& background,
                            const std::vector<Image>& shown, float unit);

}  // namespace splinevox
