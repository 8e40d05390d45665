// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/image.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/half.hpp"
#include "core/mapped_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

Picture::Picture(const Image16& image) : width(image.width), height(image.height) {
  if (image.rgba.empty()) return;
  constexpr int kSteps = 257;  // of 16 bits in one of 8
  bool narrow = true, solid = true;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    for (std::size_t c = 0; c < 4; ++c) {
      narrow &= image.rgba[i + c] % kSteps == 0;
      solid &= c < 3 || image.rgba[i + c] == 65535;
    }
  layout_ = {std::uint8_t(solid ? 3 : 4), std::uint8_t(narrow ? 1 : 2)};
  const auto values = std::make_shared_for_overwrite<std::uint8_t[]>(layout_.size(pixels()));
  std::uint8_t* to = values.get();
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const std::uint16_t* from = image.rgba.data() + i;
    if (narrow)
      for (std::size_t c = 0; c < layout_.channels; ++c) to[c] = std::uint8_t(from[c] / kSteps);
    else
      std::memcpy(to, from, layout_.size(1));
    to += layout_.size(1);
  }
  values_ = values;
}

Picture::Picture(const Image& rgba) : width(rgba.width), height(rgba.height) {
  if (rgba.data.empty()) return;
  bool solid = true;
  for (std::size_t i = 3; i < rgba.data.size(); i += 4) solid &= rgba.data[i] >= 1;
  layout_ = {std::uint8_t(solid ? 3 : 4), 2, true};
  const auto values = std::make_shared_for_overwrite<std::uint8_t[]>(layout_.size(pixels()));
  std::uint8_t* to = values.get();
  for (std::size_t i = 0; i < pixels(); ++i)
    for (std::size_t c = 0; c < layout_.channels; ++c, to += 2) {
      const float v = rgba.data[4 * i + c], most = c == 3 ? 1 : kLargestHalf;
      const std::uint16_t half = to_half(v > 0 ? std::min(v, most) : 0);  // NaN compares false
      std::memcpy(to, &half, 2);
    }
  values_ = values;
}

std::array<float, 4> Picture::halves(std::size_t i) const {
  std::array<std::uint16_t, 4> stored{0, 0, 0, kHalfOne};
  std::memcpy(stored.data(), values_.get() + layout_.size(i), layout_.size(1));
  std::array<float, 4> out;
  for (std::size_t c = 0; c < 4; ++c) out[c] = 65535 * from_half(stored[c]);
  if (cut_ && (*cut_)[i]) out[3] = 0;
  return out;
}

std::array<std::uint16_t, 4> Picture::rounded(std::size_t i) const {
  std::array<std::uint16_t, 4> out;
  const std::array<float, 4> p = halves(i);
  for (std::size_t c = 0; c < 4; ++c) out[c] = std::uint16_t(std::min(p[c], 65535.0f) + 0.5f);
  return out;
}

Image Picture::as_floats() const {
  Image out(width, height, has_values() ? 4 : 0);
  for (std::size_t i = 0; 4 * i < out.data.size(); ++i) {
    const std::array<float, 4> p = rgba(i);
    for (std::size_t c = 0; c < 4; ++c) out.data[4 * i + c] = p[c] / 65535.0f;
  }
  return out;
}

Picture::Picture(int w, int h, Layout layout, std::shared_ptr<const std::uint8_t[]> mapped)
    : width(w), height(h), layout_(layout), mapped_(true), values_(std::move(mapped)) {}

void Picture::cut(std::vector<bool> pixels) {
  cut_ = pixels.empty() ? nullptr : std::make_shared<const std::vector<bool>>(std::move(pixels));
}

Image16 Picture::unpacked() const {
  Image16 out{width, height, {}};
  if (!has_values()) return out;
  out.rgba.reserve(4 * pixels());
  for (std::size_t i = 0; i < pixels(); ++i)
    for (const std::uint16_t v : pixel(i)) out.rgba.push_back(v);
  return out;
}

bool operator==(const Picture& a, const Picture& b) {
  const auto cut = [](const Picture& p) { return p.cut_ ? *p.cut_ : std::vector<bool>(); };
  return a.width == b.width && a.height == b.height && a.layout_ == b.layout_ &&
         (!a.has_values() || std::memcmp(a.values(), b.values(), a.layout_.size(a.pixels())) == 0) &&
         cut(a) == cut(b);
}

void Picture::fetch() const {
  if (mapped_) advise(values(), layout_.size(pixels()), Pages::soon);
}

void Picture::give_back() const {
  if (mapped_) advise(values(), layout_.size(pixels()), Pages::no_more);
}

Image composite(const Picture& picture, Vec3 background) {
  if (!picture.has_values() && picture.pixels() > 0)
    fail({"composite", "the picture has been opened without its pixels", "LoadOptions::pixels", "", ""});
  Image out(picture.width, picture.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Vec3 rgb = composite(picture, x, y, background);
      for (int c = 0; c < 3; ++c)
        out.pixel(x, y)[c] = picture.layout().half ? std::min(rgb[c], 1.0f) : rgb[c];
    }
  return out;
}

Image clamped(Image picture) {
  for (float& v : picture.data) v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN compares false
  return picture;
}

}  // namespace splinevox
