// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/render/render_image.hpp"

/// Numbers as colours that a person can read. All give 3 channels in [0, 1].
namespace splinevox::run {

/// White where two pictures are equal, through red to black at a mean difference of 0.25 over the channels.
Image error_colours(const Image& a, const Image& b);

/// Near is yellow, far is violet, over `background` where nothing is hit.
/// @param near, far  depths of the two ends, scene units.
Image depth_colours(const Rendered& r, float near, float far, Vec3 background);

/// The displacement to canonical as in the paper's figures: direction is hue, distance is intensity, grey
/// does not move.
/// @param distance  full intensity, scene units, > 0.
Image flow_colours(const Rendered& r, float distance, Vec3 background);

/// Blue is static (r = 0), red moves (r = 1).
Image rigidity_colours(const Rendered& r, Vec3 background);

/// One channel three times.
Image grey(const Image& picture);

/// Pictures of one size side by side, `columns` to a row, with a white gap.
Image contact_sheet(const std::vector<Image>& pictures, int columns, int gap = 4);

}  // namespace splinevox::run
