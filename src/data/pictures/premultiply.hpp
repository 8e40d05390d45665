// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "splinevox/core/image.hpp"

namespace splinevox::data {

/// Colours of four channels times alpha, as OpenEXR stores them, and back to straight alpha. What is
/// invisible has no colour, before and after.
/// @{
inline void multiply_by_alpha(Image& rgba) {
  for (std::size_t i = 0; i < rgba.data.size(); i += 4) {
    const float alpha = rgba.data[i + 3];
    for (std::size_t c = 0; c < 3; ++c) rgba.data[i + c] = alpha > 0 ? alpha * rgba.data[i + c] : 0;
  }
}
inline void divide_by_alpha(Image& rgba) {
  for (std::size_t i = 0; i < rgba.data.size(); i += 4) {
    const float alpha = rgba.data[i + 3];
    for (std::size_t c = 0; c < 3; ++c) rgba.data[i + c] = alpha > 0 ? rgba.data[i + c] / alpha : 0;
  }
}
/// @}

}  // namespace splinevox::data
