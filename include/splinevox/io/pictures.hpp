// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

// Layers of a render as colours that can be looked at. Every picture returned has 3 channels in [0, 1]; a layer
// with another number of channels than said is an Error (Fault::input).

enum class ColourMap {
  grey,     ///< black to white
  spectrum  ///< dark blue, blue, cyan, green, yellow, orange, dark red; lightness rises, then falls again
};

/// A colour of the map at t; clamped to [0, 1].
Vec3 colour_of(ColourMap map, float t);

struct ValueRange {
  float lo = 0, hi = 1;
};

/// What depth_picture shows best: the 1st and 99th percentile of the positive finite depths, {0, 1} if there is none.
ValueRange depth_range(const Image& depth);

/// Depth (1 channel): the near end is warm or white, the far end cold or black. Pixels that hit nothing (0 or not
/// finite) take the background.
Image depth_picture(const Image& depth, ValueRange range, ColourMap map = ColourMap::spectrum,
                    Vec3 background = {1, 1, 1});

/// The 99th percentile of the lengths of displacements that are longer than 1e-6, 1 if there is none.
float flow_range(const Image& flow);

/// Displacement in space (3 channels, scene units) as in the paper's figures: the direction is the colour (red, green
/// and blue grow along +x, +y and +z and fall along the opposite), the distance is its intensity, grey is no motion:
/// 0.5 + 0.5 * direction * min(1, distance / full).
/// @param full  scene units, > 0; the distance at which a colour is full
Image flow_picture(const Image& flow, float full);

/// Rigidity (1 channel): white moves, black is static.
Image rigidity_picture(const Image& rigidity);

/// `picture` (3 channels) where `alpha` (1 channel) is 1, the background where it is 0.
Image over(const Image& picture, const Image& alpha, Vec3 background = {1, 1, 1});

/// Pictures in rows of `columns`, from the top left, with gaps between them but not around. Cells are as large as the
/// largest picture; smaller ones stand in the middle of theirs. Grey and RGBA (over the background) are understood.
/// One row: columns = pictures.size(); one column: columns = 1. @pre columns >= 1, gap >= 0
Image contact_sheet(const std::vector<Image>& pictures, int columns, int gap = 8, Vec3 background = {1, 1, 1});

/// Bytes as base64 text (RFC 4648, with padding).
std::string base64(std::span<const char> bytes);

/// The picture as PNG in a "data:" address, for the src of an <img>.
std::string png_data_uri(const Image& picture);

}  // namespace splinevox
