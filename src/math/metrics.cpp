// SPDX-License-Identifier: Apache-2.0
#include "splinevox/math/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr int kWindow = 11;
constexpr double kSigma = 1.5, kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
constexpr std::array<double, 5> kScaleWeights{0.0448, 0.2856, 0.3001, 0.2363, 0.1333};

std::string shape(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
         std::to_string(image.channels) + " channels";
}

void require_same_shape(const char* metric, const Image& a, const Image& b) {
  const bool same = a.width == b.width && a.height == b.height && a.channels == b.channels;
  const std::size_t values = a.pixels() * std::size_t(std::max(a.channels, 0));
  if (same && values > 0 && a.data.size() == values && b.data.size() == values) return;
  fail({.where = metric,
        .what = "the two pictures cannot be compared",
        .expected = "two pictures of one shape, not empty",
        .got = shape(a) + " and " + shape(b),
        .hint = {}});
}

/// One channel in double.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> data;
};

Plane channel_of(const Image& image, int c) {
  Plane plane{image.width, image.height, std::vector<double>(image.pixels())};
  for (std::size_t i = 0; i < plane.data.size(); ++i) plane.data[i] = image.data[i * image.channels + c];
  return plane;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum / double(values.size());
}

std::vector<double> gaussian(int size) {
  std::vector<double> w(size);
  double sum = 0;
  for (int i = 0; i < size; ++i) {
    const double d = i - size / 2;
    sum += w[i] = std::exp(-0.5 * d * d / (kSigma * kSigma));
  }
  for (double& x : w) x /= sum;
  return w;
}

/// Separable filter over the valid region: first along rows, then along columns (row by row, so both
/// vectorise).
Plane filter(const Plane& in, const std::vector<double>& w) {
  const int n = int(w.size()), width = in.width - n + 1, height = in.height - n + 1;
  std::vector<double> rows(std::size_t(width) * in.height, 0.0);
  for (int y = 0; y < in.height; ++y)
    for (int k = 0; k < n; ++k) {
      const double* source = in.data.data() + std::size_t(y) * in.width + k;
      double* target = rows.data() + std::size_t(y) * width;
      for (int x = 0; x < width; ++x) target[x] += w[k] * source[x];
    }
  Plane out{width, height, std::vector<double>(std::size_t(width) * height, 0.0)};
  for (int y = 0; y < height; ++y)
    for (int k = 0; k < n; ++k) {
      const double* source = rows.data() + std::size_t(y + k) * width;
      double* target = out.data.data() + std::size_t(y) * width;
      for (int x = 0; x < width; ++x) target[x] += w[k] * source[x];
    }
  return out;
}

struct Similarity {
  double full = 0;      ///< mean of luminance * contrast * structure
  double contrast = 0;  ///< mean of contrast * structure
};

/// The corners of windows of n x n pixels that meet a pixel of the mask.
PixelMask windows_on(const PixelMask& mask, int n) {
  if (mask.empty()) return {};
  const int width = mask.width() - n + 1, height = mask.height() - n + 1;
  std::vector<char> rows(std::size_t(width) * mask.height(), 0);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      if (mask.test(x, y))
        for (int u = std::max(0, x - n + 1); u <= std::min(x, width - 1); ++u)
          rows[std::size_t(y) * width + u] = 1;
  PixelMask out(width, height);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < width; ++x)
      if (rows[std::size_t(y) * width + x])
        for (int v = std::max(0, y - n + 1); v <= std::min(y, height - 1); ++v)
          out.set(std::size_t(v) * width + x);
  return out;
}

int window_of(int width, int height) {
  const int side = std::min({kWindow, width, height});
  return side % 2 ? side : side - 1;
}

/// @param without  corners of windows to leave out
Similarity similarity(const Plane& a, const Plane& b, const PixelMask& without) {
  const std::vector<double> w = gaussian(window_of(a.width, a.height));
  const double mean_a = mean_of(a.data), mean_b = mean_of(b.data);
  Plane da = a, db = b;
  for (double& v : da.data) v -= mean_a;
  for (double& v : db.data) v -= mean_b;
  Plane aa = da, bb = db, ab = da;
  for (std::size_t i = 0; i < aa.data.size(); ++i) {
    aa.data[i] *= da.data[i];
    bb.data[i] *= db.data[i];
    ab.data[i] *= db.data[i];
  }
  const Plane ma = filter(da, w), mb = filter(db, w), maa = filter(aa, w), mbb = filter(bb, w),
              mab = filter(ab, w);
  Similarity sum;
  for (std::size_t i = 0; i < ma.data.size(); ++i) {
    if (without.test(i)) continue;
    const double va = maa.data[i] - ma.data[i] * ma.data[i], vb = mbb.data[i] - mb.data[i] * mb.data[i];
    const double cov = mab.data[i] - ma.data[i] * mb.data[i];
    const double mu_a = ma.data[i] + mean_a, mu_b = mb.data[i] + mean_b;
    const double contrast = (2 * cov + kC2) / (va + vb + kC2);
    sum.contrast += contrast;
    sum.full += contrast * (2 * mu_a * mu_b + kC1) / (mu_a * mu_a + mu_b * mu_b + kC1);
  }
  const double n = double(ma.data.size() - without.count());
  return {sum.full / n, sum.contrast / n};
}

Plane halve(const Plane& in) {
  Plane out{in.width / 2, in.height / 2, {}};
  out.data.resize(std::size_t(out.width) * out.height);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const double* p = in.data.data() + std::size_t(2 * y) * in.width + 2 * x;
      out.data[std::size_t(y) * out.width + x] = 0.25 * (p[0] + p[1] + p[in.width] + p[in.width + 1]);
    }
  return out;
}

/// The mask of a halved picture: whatever holds any pixel of it.
PixelMask halve(const PixelMask& in) {
  if (in.empty()) return {};
  PixelMask out(in.width() / 2, in.height() / 2);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      if (in.test(2 * x, 2 * y) || in.test(2 * x + 1, 2 * y) || in.test(2 * x, 2 * y + 1) ||
          in.test(2 * x + 1, 2 * y + 1))
        out.set(std::size_t(y) * out.width() + x);
  return out;
}

void require_mask_of(const char* metric, const Image& picture, const PixelMask& mask) {
  if (mask.empty() || (mask.width() == picture.width && mask.height() == picture.height)) return;
  fail({.where = metric,
        .what = "the mask is not of the pictures' size",
        .expected = shape(picture),
        .got = std::to_string(mask.width()) + "x" + std::to_string(mask.height()),
        .hint = {}});
}

}  // namespace

double mean_squared_error(const Image& a, const Image& b) {
  require_same_shape("mean squared error", a, b);
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double d = double(a.data[i]) - double(b.data[i]);
    sum += d * d;
  }
  return sum / double(a.data.size());
}

double psnr_from_mse(double mse) {
  return mse == 0 ? std::numeric_limits<double>::infinity() : -10.0 * std::log10(mse);
}

double psnr(const Image& a, const Image& b) { return psnr_from_mse(mean_squared_error(a, b)); }

double capped_psnr(double db) { return db > kPsnrCap ? kPsnrCap : db; }

double mean_psnr(std::span<const double> db) {
  double sum = 0;
  for (double v : db) sum += capped_psnr(v);
  return db.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / double(db.size());
}

double psnr(const Image& a, const Image& b, const PixelMask& without) {
  if (without.empty()) return psnr(a, b);
  require_same_shape("PSNR", a, b);
  require_mask_of("PSNR", a, without);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels(); ++i) {
    if (without.test(i)) continue;
    for (int c = 0; c < a.channels; ++c) {
      const std::size_t at = i * std::size_t(a.channels) + std::size_t(c);
      const double d = double(a.data[at]) - double(b.data[at]);
      sum += d * d;
    }
  }
  const std::size_t n = (a.pixels() - without.count()) * std::size_t(a.channels);
  return n == 0 ? std::numeric_limits<double>::quiet_NaN() : psnr_from_mse(sum / double(n));
}

double ssim(const Image& a, const Image& b) { return ssim(a, b, {}); }

double ssim(const Image& a, const Image& b, const PixelMask& without) {
  require_same_shape("SSIM", a, b);
  require_mask_of("SSIM", a, without);
  const PixelMask windows = windows_on(without, window_of(a.width, a.height));
  double sum = 0;
  for (int c = 0; c < a.channels; ++c) sum += similarity(channel_of(a, c), channel_of(b, c), windows).full;
  return sum / a.channels;
}

namespace {

MsSsim ms_ssim_detail(const Image& a, const Image& b, const PixelMask& without) {
  require_same_shape("MS-SSIM", a, b);
  require_mask_of("MS-SSIM", a, without);
  const int side = std::min(a.width, a.height);
  if (side < kWindow) return {.value = ssim(a, b, without), .scales = 1};
  MsSsim result{.value = 0, .scales = 0};
  std::vector<PixelMask> windows;  // of each scale, those to leave out
  PixelMask mask = without;
  for (; result.scales < int(kScaleWeights.size()) && (side >> result.scales) >= kWindow; ++result.scales) {
    windows.push_back(windows_on(mask, kWindow));
    if (windows.back().all()) break;
    mask = halve(mask);
  }
  if (result.scales == 0) return {.value = std::numeric_limits<double>::quiet_NaN(), .scales = 0};
  double total = 0;
  for (int s = 0; s < result.scales; ++s) total += kScaleWeights[s];
  const double norm = result.scales == int(kScaleWeights.size()) ? 1.0 : 1.0 / total;

  for (int c = 0; c < a.channels; ++c) {
    Plane pa = channel_of(a, c), pb = channel_of(b, c);
    double product = 1;
    for (int s = 0; s < result.scales; ++s) {
      const Similarity now = similarity(pa, pb, windows[s]);
      double factor = s + 1 == result.scales ? now.full : now.contrast;
      if (factor < 0) {
        factor = 0;
        result.clamped = true;
      }
      product *= std::pow(factor, kScaleWeights[s] * norm);
      if (s + 1 < result.scales) {
        pa = halve(pa);
        pb = halve(pb);
      }
    }
    result.value += product / a.channels;
  }
  return result;
}

}  // namespace

MsSsim ms_ssim_detail(const Image& a, const Image& b) { return ms_ssim_detail(a, b, {}); }

double ms_ssim(const Image& a, const Image& b, const PixelMask& without) {
  return ms_ssim_detail(a, b, without).value;
}

double ms_ssim(const Image& a, const Image& b) { return ms_ssim_detail(a, b).value; }

}  // namespace splinevox
