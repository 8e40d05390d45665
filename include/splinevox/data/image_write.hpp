// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/exr.hpp"

namespace splinevox {

// Every writer here is all or nothing: the bytes go to a temporary file in the same folder, are flushed to disk,
// and only then take the name; a reader never sees half a file, and an earlier file survives a failed write.
// Devices and pipes are written in place. Whatever goes wrong (no folder, no permission, full disk, file size
// limit) is an Error with Fault::output that names the path.

/// Writes bytes to a file.
void write_file(const std::string& path, std::span<const char> bytes);

/// The picture as PNG, 8 bit a channel: 1 (grey), 3 (RGB) or 4 (straight RGBA) channels; values are clamped to
/// [0, 1] and rounded to the nearest of 0..255; NaN becomes 0. Throws Error (Fault::output) for any other picture.
std::vector<char> encode_png(const Image& image);

void write_png(const std::string& path, const Image& image);

/// Layers of one size as a single-part OpenEXR file of 32-bit floats, ZIP compressed: lossless.
void write_exr(const std::string& path, const std::vector<ExrLayer>& layers);

}  // namespace splinevox
