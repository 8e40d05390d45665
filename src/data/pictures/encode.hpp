// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "data/pictures/exr.hpp"

namespace splinevox {

/// The bytes of a PNG or OpenEXR file. `where` is what an error about the picture itself names.
std::vector<char> encode_png_for(const std::string& where, const Image& image);
std::vector<char> encode_exr_for(const std::string& where, const std::vector<ExrLayer>& layers,
                                 const ExrNotes& notes = {});
/// The picture as PNG of 16 bits a channel, every bit as it is. @param alpha  whether it is stored
std::vector<char> encode_png16(const Image16& picture, bool alpha);

}  // namespace splinevox
