// SPDX-License-Identifier: Apache-2.0
#include "train/effects/gains_where.hpp"

#include <algorithm>

#include "splinevox/math/metrics.hpp"

namespace splinevox {
namespace {

constexpr int kFewestPixels = 8;    // of a picture, to compare it there
constexpr int kFewestPictures = 4;  // that are compared

/// The pixels that a mask has, in a row.
Image picked(const Image& picture, const Image& mask) {
  Image out(int(std::count(mask.data.begin(), mask.data.end(), 1.0f)), 1, picture.channels);
  float* to = out.data.data();
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.pixel(x, y) != 0) to = std::copy_n(picture.pixel(x, y), picture.channels, to);
  return out;
}

}  // namespace

std::optional<GainsWhere> gains_where(const std::vector<Image>& where, const std::vector<Frame>& held_out,
                                      const Vec3& background, const std::vector<Image>& more,
                                      const std::vector<Image>& less) {
  GainsWhere out;
  double compared = 0, pixels = 0;
  for (std::size_t f = 0; f < held_out.size(); ++f) {
    const Image truth = picked(composite(held_out[f].image, background), where[f]);
    compared += truth.width;
    pixels += double(where[f].data.size());
    if (truth.width < kFewestPixels) continue;
    const auto quality = [&](const std::vector<Image>& of) {
      return capped_psnr(psnr(picked(of[f], where[f]), truth));
    };
    out.gains.push_back(quality(more) - quality(less));
  }
  if (int(out.gains.size()) < kFewestPictures) return {};
  out.share = compared / pixels;
  return out;
}

}  // namespace splinevox
