// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "data/pictures/premultiply.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {

Image16 area_downscale(Image16 image, int factor, ColourMean mean) {
  if (factor == 1) return image;
  const bool by_alpha = mean == ColourMean::by_alpha;
  Image16 small{image.width / factor, image.height / factor, {}};
  small.rgba.reserve(std::size_t(small.width) * small.height * 4);
  const std::uint64_t count = std::uint64_t(factor) * factor;
  const auto share = [](std::uint64_t sum, std::uint64_t of) {
    return std::uint16_t(of > 0 ? (sum + of / 2) / of : 0);
  };
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      std::array<std::uint64_t, 4> sum{};
      for (int dy = 0; dy < factor; ++dy) {
        const std::uint16_t* from = image.pixel(x * factor, y * factor + dy);
        for (int dx = 0; dx < factor; ++dx, from += 4) {
          const std::uint64_t weight = by_alpha ? from[3] : 1;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * from[c];
          sum[3] += from[3];
        }
      }
      const std::uint64_t weights = by_alpha ? sum[3] : count;
      for (std::size_t c = 0; c < 3; ++c) small.rgba.push_back(share(sum[c], weights));
      small.rgba.push_back(share(sum[3], count));
    }
  return small;
}

PixelMask area_downscale(const PixelMask& mask, int factor) {
  if (factor == 1 || mask.empty()) return mask;
  PixelMask small(mask.width() / factor, mask.height() / factor);
  for (int y = 0; y < small.height() * factor; ++y)
    for (int x = 0; x < small.width() * factor; ++x)
      if (mask.test(x, y)) small.set(std::size_t(y / factor) * small.width() + x / factor);
  return small;
}

Image area_downscale(Image image, int factor, ColourMean mean) {
  if (factor == 1) return image;
  if (mean == ColourMean::by_alpha) data::multiply_by_alpha(image);
  Image small(image.width / factor, image.height / factor, image.channels);
  const double share = 1.0 / (double(factor) * factor);
  std::vector<double> sum(static_cast<std::size_t>(image.channels));
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      std::fill(sum.begin(), sum.end(), 0.0);
      for (int dy = 0; dy < factor; ++dy)
        for (int dx = 0; dx < factor; ++dx)
          for (std::size_t c = 0; c < sum.size(); ++c)
            sum[c] += double(image.pixel(x * factor + dx, y * factor + dy)[c]);
      for (std::size_t c = 0; c < sum.size(); ++c) small.pixel(x, y)[c] = float(share * sum[c]);
    }
  if (mean == ColourMean::by_alpha) data::divide_by_alpha(small);
  return small;
}

Picture area_downscale(const Picture& picture, int factor) {
  if (picture.layout().half) return Picture(area_downscale(picture.as_floats(), factor));
  return area_downscale(picture.unpacked(), factor);
}

Camera area_downscale(Camera camera, int factor) {
  camera.width /= factor;
  camera.height /= factor;
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value /= factor;
  return camera;
}

}  // namespace splinevox
