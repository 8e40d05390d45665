// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/image.hpp"

namespace splinevox {

/// The picture as PNG, 8 bit a channel: 1 (grey), 3 (RGB) or 4 (straight RGBA) channels; values are clamped
/// to [0, 1] and rounded to the nearest of 0..255; NaN becomes 0. Throws Error (Fault::output) for any other
/// picture.
std::vector<char> encode_png(const Image& image);

/// The same to a file, all or nothing. Throws Error (Fault::output) naming the path.
void write_png(const std::string& path, const Image& image);

}  // namespace splinevox
