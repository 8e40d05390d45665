// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Float picture, row-major from the top left, channels interleaved. Colour is display-referred in [0, 1]
/// exactly as stored in the PNG (no linearisation); alpha, where there is one, is straight.
struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<float> data;  ///< [height * width * channels]

  Image() = default;
  Image(int w, int h, int c) : width(w), height(h), channels(c), data(std::size_t(w) * h * c, 0.0f) {}
  std::size_t pixels() const { return std::size_t(width) * height; }
  float* pixel(int x, int y) { return data.data() + (std::size_t(y) * width + x) * channels; }
  const float* pixel(int x, int y) const { return data.data() + (std::size_t(y) * width + x) * channels; }
};

/// Straight-alpha RGBA picture as it is read and made: 16 bit a channel, 65535 = 1. An 8-bit
/// PNG value v is 257 v, which is exact; area-filtered values are rounded to 1/65535.
struct Image16 {
  int width = 0, height = 0;
  std::vector<std::uint16_t> rgba;  ///< [height * width * 4]

  std::size_t pixels() const { return std::size_t(width) * height; }
  const std::uint16_t* pixel(int x, int y) const { return rgba.data() + (std::size_t(y) * width + x) * 4; }
};

/// The same as training keeps it in memory: where every value is one of 8 bits, in 8, which is half as much
/// and the same picture.
class Picture {
 public:
  int width = 0, height = 0;

  Picture() = default;
  Picture(Image16 image);
  std::size_t pixels() const { return std::size_t(width) * height; }
  /// False of a frame whose picture was not read.
  bool has_values() const { return !narrow_.empty() || !wide_.empty(); }
  std::array<std::uint16_t, 4> pixel(std::size_t i) const {
    if (!narrow_.empty()) {
      const std::uint8_t* p = narrow_.data() + 4 * i;
      return {std::uint16_t(257 * p[0]), std::uint16_t(257 * p[1]), std::uint16_t(257 * p[2]),
              std::uint16_t(257 * p[3])};
    }
    const std::uint16_t* p = wide_.data() + 4 * i;
    return {p[0], p[1], p[2], p[3]};
  }
  std::array<std::uint16_t, 4> pixel(int x, int y) const { return pixel(std::size_t(y) * width + x); }
  /// Changes the alpha of one pixel. @param alpha  0 or 65535
  void set_alpha(std::size_t i, std::uint16_t alpha) {
    if (!narrow_.empty())
      narrow_[4 * i + 3] = std::uint8_t(alpha >> 8);
    else
      wide_[4 * i + 3] = alpha;
  }
  Image16 unpacked() const;
  friend bool operator==(const Picture&, const Picture&) = default;

 private:
  std::vector<std::uint8_t> narrow_;  ///< [height * width * 4], or
  std::vector<std::uint16_t> wide_;   ///< as many
};

/// One pixel of straight RGBA over a background.
inline Vec3 composite(const Picture& picture, int x, int y, const Vec3& background) {
  const auto p = picture.pixel(x, y);
  const float alpha = p[3] / 65535.0f;
  return {p[0] / 65535.0f * alpha + background.x * (1 - alpha),
          p[1] / 65535.0f * alpha + background.y * (1 - alpha),
          p[2] / 65535.0f * alpha + background.z * (1 - alpha)};
}
/// Straight RGBA over a background: [height * width * 3].
Image composite(const Picture& picture, Vec3 background);
/// Every value brought into [0, 1]; NaN becomes 0.
Image clamped(Image picture);

}  // namespace splinevox
