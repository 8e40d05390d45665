// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "splinevox/core/error.hpp"
#include "splinevox/data/image_write.hpp"

namespace splinevox {
namespace {

void require_channels(const char* what, const Image& image, int channels) {
  if (image.channels == channels && image.data.size() == image.pixels() * std::size_t(channels)) return;
  fail({.where = what,
        .what = "this layer cannot be shown",
        .expected = std::to_string(channels) + (channels == 1 ? " channel" : " channels"),
        .got = std::to_string(image.channels),
        .hint = {}});
}

void set(Image& image, std::size_t i, const Vec3& colour) {
  for (int c = 0; c < 3; ++c) image.data[3 * i + std::size_t(c)] = std::clamp(colour[c], 0.0f, 1.0f);
}

/// The value below which `share` of the values lie. @pre not empty
float percentile(std::vector<float>& values, double share) {
  const auto k = std::ptrdiff_t(std::floor(share * double(values.size() - 1) + 0.5));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[std::size_t(k)];
}

Vec3 flow_at(const Image& flow, std::size_t i) {
  return {flow.data[3 * i], flow.data[3 * i + 1], flow.data[3 * i + 2]};
}

/// Any kind of picture as opaque RGB.
Image opaque(const Image& picture, const Vec3& background) {
  if (picture.channels == 3) return picture;
  Image out(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.pixels(); ++i) {
    const float* p = picture.data.data() + i * std::size_t(picture.channels);
    const float alpha = picture.channels == 4 ? p[3] : 1;
    const Vec3 colour = picture.channels == 4 ? Vec3{p[0], p[1], p[2]} : Vec3{p[0], p[0], p[0]};
    set(out, i, alpha * colour + (1 - alpha) * background);
  }
  return out;
}

}  // namespace

Vec3 colour_of(ColourMap map, float t) {
  t = t > 0 ? std::min(t, 1.0f) : 0.0f;  // also NaN
  if (map == ColourMap::grey) return {t, t, t};
  static constexpr std::array<Vec3, 8> kSpectrum{{{0.16f, 0.10f, 0.40f},
                                                  {0.22f, 0.36f, 0.85f},
                                                  {0.10f, 0.67f, 0.92f},
                                                  {0.16f, 0.86f, 0.66f},
                                                  {0.58f, 0.92f, 0.28f},
                                                  {0.96f, 0.80f, 0.20f},
                                                  {0.93f, 0.40f, 0.10f},
                                                  {0.55f, 0.06f, 0.04f}}};
  const float at = t * float(kSpectrum.size() - 1);
  const auto i = std::min(std::size_t(at), kSpectrum.size() - 2);
  return kSpectrum[i] + (at - float(i)) * (kSpectrum[i + 1] - kSpectrum[i]);
}

ValueRange depth_range(const Image& depth) {
  require_channels("depth", depth, 1);
  std::vector<float> hits;
  for (const float d : depth.data)
    if (std::isfinite(d) && d > 0) hits.push_back(d);
  if (hits.empty()) return {};
  return {percentile(hits, 0.01), percentile(hits, 0.99)};
}

Image depth_picture(const Image& depth, ValueRange range, ColourMap map, Vec3 background) {
  require_channels("depth", depth, 1);
  Image out(depth.width, depth.height, 3);
  const float width = range.hi - range.lo;
  for (std::size_t i = 0; i < depth.pixels(); ++i) {
    const float d = depth.data[i];
    const bool hit = std::isfinite(d) && d > 0;
    set(out, i, hit ? colour_of(map, width > 0 ? (range.hi - d) / width : 0.5f) : background);
  }
  return out;
}

float flow_range(const Image& flow) {
  require_channels("flow", flow, 3);
  std::vector<float> lengths;
  for (std::size_t i = 0; i < flow.pixels(); ++i) {
    const float l = length(flow_at(flow, i));
    if (std::isfinite(l) && l > 1e-6f) lengths.push_back(l);
  }
  return lengths.empty() ? 1.0f : percentile(lengths, 0.99);
}

Image flow_picture(const Image& flow, float full) {
  require_channels("flow", flow, 3);
  Image out(flow.width, flow.height, 3);
  for (std::size_t i = 0; i < flow.pixels(); ++i) {
    const Vec3 d = flow_at(flow, i);
    const float l = length(d);
    Vec3 colour{0.5f, 0.5f, 0.5f};
    if (std::isfinite(l) && l > 0 && full > 0) colour += d * (0.5f * std::min(1.0f, l / full) / l);
    set(out, i, colour);
  }
  return out;
}

Image rigidity_picture(const Image& rigidity) {
  require_channels("rigidity", rigidity, 1);
  Image out(rigidity.width, rigidity.height, 3);
  for (std::size_t i = 0; i < rigidity.pixels(); ++i) set(out, i, colour_of(ColourMap::grey, rigidity.data[i]));
  return out;
}

Image over(const Image& picture, const Image& alpha, Vec3 background) {
  require_channels("picture", picture, 3);
  require_channels("alpha", alpha, 1);
  if (picture.pixels() != alpha.pixels() || picture.width != alpha.width)
    fail({.where = "alpha",
          .what = "this layer does not fit its picture",
          .expected = std::to_string(picture.width) + "x" + std::to_string(picture.height),
          .got = std::to_string(alpha.width) + "x" + std::to_string(alpha.height),
          .hint = {}});
  Image out(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.pixels(); ++i) {
    const float a = std::clamp(alpha.data[i], 0.0f, 1.0f);
    set(out, i, a * flow_at(picture, i) + (1 - a) * background);
  }
  return out;
}

Image contact_sheet(const std::vector<Image>& pictures, int columns, int gap, Vec3 background) {
  if (pictures.empty()) return {};
  int width = 0, height = 0;
  for (const Image& picture : pictures) {
    if (picture.channels != 1 && picture.channels != 4) require_channels("contact sheet", picture, 3);
    width = std::max(width, picture.width);
    height = std::max(height, picture.height);
  }
  const int count = int(pictures.size()), across = std::min(columns, count), down = (count + across - 1) / across;
  Image sheet(across * (width + gap) - gap, down * (height + gap) - gap, 3);
  for (std::size_t i = 0; i < sheet.pixels(); ++i) set(sheet, i, background);
  for (int k = 0; k < count; ++k) {
    const Image picture = opaque(pictures[std::size_t(k)], background);
    const int left = k % across * (width + gap) + (width - picture.width) / 2;
    const int top = k / across * (height + gap) + (height - picture.height) / 2;
    for (int y = 0; y < picture.height; ++y)
      std::copy_n(picture.pixel(0, y), 3 * picture.width, sheet.pixel(left, top + y));
  }
  return sheet;
}

std::string base64(std::span<const char> bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kLetters[word >> (18 - 6 * k) & 63];  // k letters need k bytes
  }
  return text;
}

std::string png_data_uri(const Image& picture) { return "data:image/png;base64," + base64(encode_png(picture)); }

}  // namespace splinevox
