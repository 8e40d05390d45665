// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
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

/// The same as training keeps it: a handle of values that never change, in memory or in a mapped file. Copies
/// share them. Values take as little as holds them exactly: 8 bits a channel where every one is such a value,
/// and no alpha where every pixel is opaque. Pictures of floats are kept as halves and may go beyond 1.
class Picture {
 public:
  /// How values are stored, row by row and interleaved.
  struct Layout {
    std::uint8_t channels = 0;  ///< 3 (opaque) or 4 (straight alpha); 0: there are no values
    std::uint8_t bytes = 0;     ///< a channel, 1 or 2
    bool half = false;          ///< those two are a half
    std::size_t size(std::size_t pixels) const { return pixels * channels * bytes; }
    friend bool operator==(const Layout&, const Layout&) = default;
  };
  int width = 0, height = 0;

  Picture() = default;
  Picture(const Image16& image);
  /// As halves. @param rgba  4 channels, straight alpha; values are clamped to [0, kLargestHalf], alpha to
  /// [0, 1]; NaN becomes 0
  explicit Picture(const Image& rgba);
  /// Of values that lie in a mapped file, which they keep open.
  Picture(int width, int height, Layout layout, std::shared_ptr<const std::uint8_t[]> mapped);

  std::size_t pixels() const { return std::size_t(width) * height; }
  /// False of a frame whose picture was not read.
  bool has_values() const { return layout_.channels > 0; }
  bool opaque() const { return layout_.channels != 4 && !cut_; }
  Layout layout() const { return layout_; }
  /// As they are stored, [layout().size(pixels())].
  const std::uint8_t* values() const { return values_.get(); }

  /// Straight alpha, 65535 = 1; what is beyond 1 is 1.
  std::array<std::uint16_t, 4> pixel(std::size_t i) const {
    if (layout_.half) return rounded(i);
    const std::uint8_t* p = values_.get() + layout_.size(i);
    std::array<std::uint16_t, 4> out{0, 0, 0, 65535};
    if (layout_.bytes == 1) {
      for (std::size_t c = 0; c < 3; ++c) out[c] = std::uint16_t(257 * p[c]);
      if (layout_.channels == 4) out[3] = std::uint16_t(257 * p[3]);
    } else if (layout_.channels == 4) {
      std::memcpy(out.data(), p, 8);
    } else {
      std::memcpy(out.data(), p, 6);
    }
    if (cut_ && (*cut_)[i]) out[3] = 0;
    return out;
  }
  std::array<std::uint16_t, 4> pixel(int x, int y) const { return pixel(std::size_t(y) * width + x); }
  /// The same, with what is beyond 1, and between.
  std::array<float, 4> rgba(std::size_t i) const {
    if (layout_.half) return halves(i);
    const auto p = pixel(i);
    return {float(p[0]), float(p[1]), float(p[2]), float(p[3])};
  }
  std::array<float, 4> rgba(int x, int y) const { return rgba(std::size_t(y) * width + x); }

  /// Gives alpha 0 to pixels; none: undoes it. @param pixels  [pixels()] or empty
  void cut(std::vector<bool> pixels);
  Image16 unpacked() const;
  /// As floats: 4 channels, straight alpha, 1 = 1.
  Image as_floats() const;
  friend bool operator==(const Picture& a, const Picture& b);

  /// Of a mapped picture: asks the system to read it in, which takes no time here; and gives the memory back
  /// that holds what was read. Pixels may be read at any time, before, between and after.
  /// @{
  void fetch() const;
  void give_back() const;
  /// @}

 private:
  std::array<std::uint16_t, 4> rounded(std::size_t i) const;
  std::array<float, 4> halves(std::size_t i) const;
  Layout layout_;
  bool mapped_ = false;
  std::shared_ptr<const std::uint8_t[]> values_;
  std::shared_ptr<const std::vector<bool>> cut_;
};

/// A scope that reads all of a picture.
struct ReadAll {
  const Picture& picture;
  explicit ReadAll(const Picture& p) : picture(p) { picture.fetch(); }
  ReadAll(const ReadAll&) = delete;
  ReadAll& operator=(const ReadAll&) = delete;
  ~ReadAll() { picture.give_back(); }
};

/// One pixel of straight RGBA over a background.
inline Vec3 composite(const Picture& picture, int x, int y, const Vec3& background) {
  const auto p = picture.rgba(x, y);
  const float alpha = p[3] / 65535.0f;
  return {p[0] / 65535.0f * alpha + background.x * (1 - alpha),
          p[1] / 65535.0f * alpha + background.y * (1 - alpha),
          p[2] / 65535.0f * alpha + background.z * (1 - alpha)};
}
/// Straight RGBA over a background: [height * width * 3], what is beyond 1 as 1.
Image composite(const Picture& picture, Vec3 background);
/// Every value brought into [0, 1]; NaN becomes 0.
Image clamped(Image picture);

}  // namespace splinevox
