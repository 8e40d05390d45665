// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/image.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/mapped_file.hpp"

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
  Image out(picture.width, picture.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Vec3 rgb = composite(picture, x, y, background);
      for (int c = 0; c < 3; ++c) out.pixel(x, y)[c] = rgb[c];
    }
  return out;
}

Image clamped(Image picture) {
  for (float& v : picture.data) v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN compares false
  return picture;
}

}  // namespace splinevox
