// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "data/pictures/exr.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox {

// Writers are all or nothing, and throw Error (Fault::output) naming the path: core/atomic_file.hpp.

/// The picture as PNG, 8 bit a channel: 1 (grey), 3 (RGB) or 4 (straight RGBA) channels; values are clamped
/// to [0, 1] and rounded to the nearest of 0..255; NaN becomes 0. Throws Error (Fault::output) for any other
/// picture.
std::vector<char> encode_png(const Image& image);

void write_png(const std::string& path, const Image& image);

/// Layers of one size as a single-part OpenEXR file of 32-bit floats, ZIP compressed: lossless.
void write_exr(const std::string& path, const std::vector<ExrLayer>& layers);

}  // namespace splinevox
