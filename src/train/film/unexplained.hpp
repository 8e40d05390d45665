// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/core/pixel_mask.hpp"

namespace splinevox {

/// How far a picture is from what a model shows of it, where neither blur nor a shift by a pixel explains the
/// difference; [pixels], of the worst channel.
///
/// A lattice blurs, and poses err. So a colour is explained if it lies within those that the model shows at
/// this pixel and the eight beside it, or if the model's colour lies within those of the picture there.
std::vector<float> unexplained(const Image& picture, const Image& shown);
/// The same of the differences between channels, which a white highlight does not change. 0 where one of both
/// has a channel at its end.
std::vector<float> unexplained_hue(const Image& picture, const Image& shown);

/// Pixels with a clear error, together with others of that kind, and all fainter ones that hang together with
/// them.
/// @param known  pixels of which something can be said; [pixels]
/// @param unit  of brightness
PixelMask clear_errors(const std::vector<float>& error, const std::vector<char>& known, int width, int height,
                       float unit);

}  // namespace splinevox
