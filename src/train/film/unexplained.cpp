// SPDX-License-Identifier: Apache-2.0
#include "train/film/unexplained.hpp"

#include <algorithm>
#include <limits>

#include "splinevox/core/vec3.hpp"

namespace splinevox {
namespace {

constexpr float kClear = 0.04f;   ///< of brightness
constexpr float kFaint = 0.02f;   ///< of brightness
constexpr int kFewestBeside = 3;  ///< of a pixel's eight neighbours that have a clear error with it

/// Calls act(pixel) for a pixel and the eight beside it.
template <class Act>
void each_beside(int x, int y, int width, int height, const Act& act) {
  for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
      act(std::size_t(v) * std::size_t(width) + std::size_t(u));
}

/// How far a colour is beyond all that a picture has at a pixel and beside it.
float beyond(const float* colour, const Image& picture, int x, int y) {
  constexpr float kAny = std::numeric_limits<float>::infinity();
  Vec3 lo{kAny, kAny, kAny}, hi{-kAny, -kAny, -kAny};
  each_beside(x, y, picture.width, picture.height, [&](std::size_t i) {
    const float* p = picture.data.data() + 3 * i;
    lo = min(lo, Vec3{p[0], p[1], p[2]});
    hi = max(hi, Vec3{p[0], p[1], p[2]});
  });
  float out = 0;
  for (int c = 0; c < 3; ++c) out = std::max({out, lo[c] - colour[c], colour[c] - hi[c]});
  return out;
}

}  // namespace

std::vector<float> unexplained(const Image& picture, const Image& shown) {
  std::vector<float> out;
  out.reserve(picture.data.size() / 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      out.push_back(
          std::min(beyond(picture.pixel(x, y), shown, x, y), beyond(shown.pixel(x, y), picture, x, y)));
  return out;
}

std::vector<float> unexplained_hue(const Image& picture, const Image& shown) {
  constexpr float kEnd = 0.97f;
  const auto differences = [](const Image& of) {
    Image out(of.width, of.height, 3);
    for (std::size_t i = 0; i < of.data.size(); i += 3)
      for (std::size_t c = 0; c < 3; ++c) out.data[i + c] = of.data[i + c] - of.data[i + (c + 1) % 3];
    return out;
  };
  std::vector<float> out = unexplained(differences(picture), differences(shown));
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      if (picture.data[3 * i + c] > kEnd || shown.data[3 * i + c] > kEnd) out[i] = 0;
  return out;
}

PixelMask clear_errors(const std::vector<float>& error, const std::vector<char>& known, int width, int height,
                       float unit) {
  const auto clear = [&](std::size_t i) { return known[i] && error[i] > kClear * unit; };
  PixelMask out(width, height);
  std::vector<std::size_t> open;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(width) + std::size_t(x);
      if (!clear(i)) continue;
      int with = -1;
      each_beside(x, y, width, height, [&](std::size_t k) { with += clear(k); });
      if (with < kFewestBeside) continue;
      out.set(i);
      open.push_back(i);
    }
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    each_beside(int(i % std::size_t(width)), int(i / std::size_t(width)), width, height, [&](std::size_t k) {
      if (out.test(k) || !known[k] || !(error[k] > kFaint * unit)) return;
      out.set(k);
      open.push_back(k);
    });
  }
  return out;
}

}  // namespace splinevox
