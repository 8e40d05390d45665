// SPDX-License-Identifier: Apache-2.0
#include "train/effects/gains_where.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "math/median.hpp"
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

constexpr int kTile = 8;               // pixels
constexpr int kFewestTiles = 8;        // of a picture, to compare them
constexpr int kFewestTilesOfMany = 4;  // of a picture, where a camera's pictures are compared as well
constexpr double kMedianError = 1.4826 * 1.2533;  // of a normal sample's median, in its median deviation
constexpr double kSureRatio = 2.7;  // of variances: chance alone comes to it once in a hundred times
constexpr std::size_t kApart = 10;  // one tile in so many may show what moves: those furthest from the median
constexpr float kContrast = 0.02f;  // of a pixel to the background, units of brightness, that shows something

/// Sums of a tile over the pixels that show something and are not ignored.
struct TileSums {
  Vec3d truth{}, shown{};
  int pixels = 0;
};

TileSums sums_of(const Image& truth, const PixelMask& ignored, const Vec3& background, const Image& shown,
                 float least, int x0, int y0) {
  TileSums out;
  for (int y = y0; y < std::min(y0 + kTile, truth.height); ++y)
    for (int x = x0; x < std::min(x0 + kTile, truth.width); ++x) {
      const float *t = truth.pixel(x, y), *s = shown.pixel(x, y);
      float contrast = 0;
      for (int c = 0; c < 3; ++c) contrast = std::max(contrast, std::abs(t[c] - background[c]));
      if (contrast < least || ignored.test(x, y)) continue;
      for (int c = 0; c < 3; ++c) {
        out.truth[c] += double(t[c]);
        out.shown[c] += double(s[c]);
      }
      ++out.pixels;
    }
  return out;
}

/// Logarithms of truth over shown in the tiles of a picture, by channel.
std::array<std::vector<double>, 3> ratios_of(const Frame& frame, const Vec3& background, const Image& shown,
                                             float unit) {
  const Image truth = composite(frame.image, background);
  std::array<std::vector<double>, 3> out;
  for (int y = 0; y < truth.height; y += kTile)
    for (int x = 0; x < truth.width; x += kTile) {
      const TileSums s = sums_of(truth, frame.ignored, background, shown, kContrast * unit, x, y);
      if (s.pixels < kTile * kTile / 2) continue;
      const double least = double(kContrast * unit) * s.pixels;
      for (int c = 0; c < 3; ++c)
        if (s.truth[c] > least && s.shown[c] > least)
          out[std::size_t(c)].push_back(std::log(s.truth[c] / s.shown[c]));
    }
  return out;
}

/// Calls visit(picture, channel, median, ratios) wherever a channel of a picture has that many tiles.
template <class Visit>
void each_median(const std::vector<Frame>& held_out, const Vec3& background, const std::vector<Image>& shown,
                 float unit, int fewest, const Visit& visit) {
  for (std::size_t f = 0; f < held_out.size(); ++f) {
    auto ratios = ratios_of(held_out[f], background, shown[f], unit);
    for (std::size_t c = 0; c < 3; ++c)
      if (std::vector<double>& r = ratios[c]; int(r.size()) >= fewest) visit(held_out[f], c, median(r), r);
  }
}

double variance(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double v : values) sum += v / double(values.size());
  for (const double v : values) squares += (v - sum) * (v - sum) / double(values.size());
  return squares;
}

}  // namespace

double whole_share(const std::vector<Frame>& held_out, const Vec3& background,
                   const std::vector<Image>& shown, float unit) {
  std::array<std::vector<double>, 3> medians;
  double within = 0, between = 0;
  each_median(held_out, background, shown, unit, kFewestTiles,
              [&](const Frame&, std::size_t c, double middle, std::vector<double>& r) {
                medians[c].push_back(middle);
                std::sort(r.begin(), r.end(),
                          [&](double a, double b) { return std::abs(a - middle) < std::abs(b - middle); });
                r.resize(r.size() - r.size() / kApart);
                within += variance(r);
              });
  std::size_t count = 0;
  for (const auto& m : medians) {
    between += variance(m) * double(m.size());
    count += m.size();
  }
  return int(count) >= 3 * kFewestPictures && between > 0 ? between / (between + within) : 0;
}

CameraSpread cameras_spread(const std::vector<Frame>& held_out, const Vec3& background,
                            const std::vector<Image>& shown, float unit) {
  std::array<std::map<int, std::vector<double>>, 3> medians;
  double noise = 0;  // of the medians, sum of variances
  each_median(held_out, background, shown, unit, kFewestTilesOfMany,
              [&](const Frame& picture, std::size_t c, double middle, std::vector<double>& r) {
                medians[c][picture.camera_id].push_back(middle);
                for (double& v : r) v = std::abs(v - middle);
                noise += std::pow(kMedianError * median(r), 2) / double(r.size());
              });
  // Analysis of variance, one way, the channels together: sums of squares of all, and within cameras.
  double all = 0, within = 0, pictures = 0, shares = 0, cameras = 0;
  for (const auto& channel : medians) {
    std::vector<double> together;
    double squares = 0;
    for (const auto& [camera, m] : channel) {
      together.insert(together.end(), m.begin(), m.end());
      within += variance(m) * double(m.size());
      squares += double(m.size() * m.size());
    }
    if (together.empty()) continue;
    all += variance(together) * double(together.size());
    pictures += double(together.size());
    shares += squares / double(together.size());
    cameras += double(channel.size());
  }
  const double freedom = cameras - 3, left = pictures - cameras;  // a mean for each channel
  if (freedom < 3 || left < 3) return {};
  const double between = (all - within) / freedom, chance = within / left;
  return {between > kSureRatio * chance ? std::sqrt((between - chance) * freedom / (pictures - shares)) : 0,
          std::sqrt(std::max(0.0, chance - noise / pictures))};
}

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
