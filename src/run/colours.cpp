// SPDX-License-Identifier: Apache-2.0
#include "run/colours.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox::run {
namespace {

constexpr float kFullError = 0.25f;

/// Piecewise linear between equally spaced colours, t clamped to [0, 1].
template <std::size_t N>
Vec3 ramp(const Vec3 (&colours)[N], float t) {
  const float s = std::clamp(t, 0.0f, 1.0f) * float(N - 1);
  const std::size_t i = std::min(std::size_t(s), N - 2);
  return (1 - (s - float(i))) * colours[i] + (s - float(i)) * colours[i + 1];
}

constexpr Vec3 kHeat[] = {
    {1, 1, 1}, {1, 0.75f, 0.55f}, {0.9f, 0.25f, 0.15f}, {0.45f, 0.02f, 0.1f}, {0, 0, 0}};
constexpr Vec3 kDepth[] = {{0.99f, 0.91f, 0.14f},
                           {0.37f, 0.79f, 0.38f},
                           {0.13f, 0.57f, 0.55f},
                           {0.23f, 0.32f, 0.55f},
                           {0.27f, 0, 0.33f}};
constexpr Vec3 kMoves[] = {{0.16f, 0.29f, 0.62f}, {0.87f, 0.87f, 0.87f}, {0.75f, 0.15f, 0.12f}};

/// colour(x, y) weighted by alpha over the background.
template <class Colour>
Image over(const Rendered& r, Vec3 background, Colour colour) {
  Image out(r.alpha.width, r.alpha.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const float alpha = std::clamp(*r.alpha.pixel(x, y), 0.0f, 1.0f);
      const Vec3 c = alpha > 1e-3f ? alpha * colour(x, y, alpha) + (1 - alpha) * background : background;
      for (int k = 0; k < 3; ++k) out.pixel(x, y)[k] = std::clamp(c[k], 0.0f, 1.0f);
    }
  return out;
}

}  // namespace

Image error_colours(const Image& a, const Image& b) {
  Image out(a.width, a.height, 3);
  for (std::size_t i = 0; i < a.pixels(); ++i) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::abs(a.data[3 * i + k] - b.data[3 * i + k]);
    const Vec3 c = ramp(kHeat, sum / 3 / kFullError);
    for (int k = 0; k < 3; ++k) out.data[3 * i + k] = c[k];
  }
  return out;
}

Image depth_colours(const Rendered& r, float near, float far, Vec3 background) {
  return over(r, background, [&](int x, int y, float) {
    return ramp(kDepth, (*r.depth.pixel(x, y) - near) / std::max(far - near, 1e-6f));
  });
}

Image flow_colours(const Rendered& r, float distance, Vec3 background) {
  return over(r, background, [&](int x, int y, float alpha) {
    const float* f = r.flow.pixel(x, y);
    const Vec3 d = Vec3{f[0], f[1], f[2]} * (1 / alpha);
    const float n = length(d);
    const Vec3 half{0.5f, 0.5f, 0.5f};
    return n > 0 ? half + d * (0.5f * std::min(n / distance, 1.0f) / n) : half;
  });
}

Image rigidity_colours(const Rendered& r, Vec3 background) {
  return over(r, background,
              [&](int x, int y, float alpha) { return ramp(kMoves, *r.rigidity.pixel(x, y) / alpha); });
}

Image grey(const Image& picture) {
  Image out(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = std::clamp(picture.data[i / 3 * picture.channels], 0.0f, 1.0f);
  return out;
}

Image contact_sheet(const std::vector<Image>& pictures, int columns, int gap) {
  const int w = pictures[0].width, h = pictures[0].height,
            rows = (int(pictures.size()) + columns - 1) / columns;
  Image out(columns * w + (columns - 1) * gap, rows * h + (rows - 1) * gap, 3);
  std::fill(out.data.begin(), out.data.end(), 1.0f);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int x0 = int(i) % columns * (w + gap), y0 = int(i) / columns * (h + gap);
    for (int y = 0; y < h; ++y)
      std::copy_n(pictures[i].pixel(0, y), std::size_t(3 * w), out.pixel(x0, y0 + y));
  }
  return out;
}

}  // namespace splinevox::run
