// SPDX-License-Identifier: Apache-2.0
#include "splinevox/math/metrics.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

Image noise(int w, int h, int c, unsigned seed, float lo = 0.0f, float hi = 1.0f) {
  Image image(w, h, c);
  std::mt19937 rng(seed);
  for (float& v : image.data) v = lo + (hi - lo) * float(rng() >> 8) / float(1 << 24);
  return image;
}

Image constant(int w, int h, int c, float value) {
  Image image(w, h, c);
  for (float& v : image.data) v = value;
  return image;
}

/// A waving picture with structure at every scale, as a stand-in for a photograph.
Image waves(int w, int h, int c, double shift) {
  Image image(w, h, c);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int k = 0; k < c; ++k)
        image.pixel(x, y)[k] = float(0.5 + 0.2 * std::sin(0.11 * x + 0.05 * y + k + shift) +
                                     0.2 * std::cos(0.017 * x * (k + 1) - 0.031 * y - shift) +
                                     0.1 * std::sin(0.9 * x + 0.7 * y));
  return image;
}

Image inverted(Image image) {
  for (float& v : image.data) v = 1 - v;
  return image;
}

/// SSIM straight from its definition: for each window the weighted means, then the weighted squared
/// deviations from them. Returns {mean of the full index, mean of its contrast-structure part} of one
/// channel.
std::array<double, 2> direct(const std::vector<double>& a, const std::vector<double>& b, int w, int h) {
  int n = std::min({11, w, h});
  if (n % 2 == 0) --n;
  std::vector<double> weight(std::size_t(n) * n);
  double total = 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const double dx = x - n / 2, dy = y - n / 2;
      total += weight[y * n + x] = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
    }
  std::array<double, 2> sum{};
  for (int y0 = 0; y0 + n <= h; ++y0)
    for (int x0 = 0; x0 + n <= w; ++x0) {
      const auto windowed = [&](auto value) {
        double s = 0;
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x) s += weight[y * n + x] * value((y0 + y) * w + x0 + x);
        return s / total;
      };
      const double ma = windowed([&](int i) { return a[i]; }), mb = windowed([&](int i) { return b[i]; });
      const double va = windowed([&](int i) { return (a[i] - ma) * (a[i] - ma); });
      const double vb = windowed([&](int i) { return (b[i] - mb) * (b[i] - mb); });
      const double cov = windowed([&](int i) { return (a[i] - ma) * (b[i] - mb); });
      const double cs = (2 * cov + 0.0009) / (va + vb + 0.0009);
      sum[1] += cs;
      sum[0] += cs * (2 * ma * mb + 0.0001) / (ma * ma + mb * mb + 0.0001);
    }
  const double count = double(w - n + 1) * (h - n + 1);
  return {sum[0] / count, sum[1] / count};
}

std::vector<double> plane(const Image& image, int c) {
  std::vector<double> out;
  for (std::size_t i = 0; i < image.pixels(); ++i) out.push_back(image.data[i * image.channels + c]);
  return out;
}

double direct_ssim(const Image& a, const Image& b) {
  double sum = 0;
  for (int c = 0; c < a.channels; ++c) sum += direct(plane(a, c), plane(b, c), a.width, a.height)[0];
  return sum / a.channels;
}

double direct_ms_ssim(const Image& a, const Image& b, int scales) {
  constexpr std::array<double, 5> kWeights{0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  double total = 0;
  for (int s = 0; s < scales; ++s) total += kWeights[s];
  if (scales == 5) total = 1;
  double mean = 0;
  for (int c = 0; c < a.channels; ++c) {
    std::vector<double> pa = plane(a, c), pb = plane(b, c);
    int w = a.width, h = a.height;
    double product = 1;
    for (int s = 0; s < scales; ++s) {
      const auto [full, cs] = direct(pa, pb, w, h);
      product *= std::pow(std::max(0.0, s + 1 == scales ? full : cs), kWeights[s] / total);
      for (auto* p : {&pa, &pb}) {
        std::vector<double> half;
        for (int y = 0; y + 1 < h; y += 2)
          for (int x = 0; x + 1 < w; x += 2)
            half.push_back(
                ((*p)[y * w + x] + (*p)[y * w + x + 1] + (*p)[(y + 1) * w + x] + (*p)[(y + 1) * w + x + 1]) /
                4);
        *p = half;
      }
      w /= 2;
      h /= 2;
    }
    mean += product / a.channels;
  }
  return mean;
}

TEST_SUITE("math/metrics") {
  TEST_CASE("PSNR of a constant difference is -20 log10 of it, and infinite for none") {
    const Image a = constant(7, 5, 3, 0.25f), b = constant(7, 5, 3, 0.375f);
    CHECK(mean_squared_error(a, b) == doctest::Approx(0.125 * 0.125).epsilon(1e-12));
    CHECK(psnr(a, b) == doctest::Approx(-20 * std::log10(0.125)).epsilon(1e-12));
    CHECK(psnr(a, a) == std::numeric_limits<double>::infinity());
  }

  TEST_CASE("a mean of PSNRs stays finite when one picture is reproduced exactly") {
    const std::array<double, 2> db{30.0, std::numeric_limits<double>::infinity()};
    CHECK(capped_psnr(db[1]) == 100.0);
    CHECK(mean_psnr(db) == 65.0);
    CHECK(std::isnan(mean_psnr({})));
    CHECK(std::isnan(capped_psnr(std::nan(""))));
  }

  TEST_CASE("SSIM equals its definition summed window by window") {
    struct Row {
      const char* name;
      Image a, b;
    };
    const Row rows[] = {
        {"noise", noise(23, 19, 3, 1), noise(23, 19, 3, 2)},
        {"waves", waves(40, 31, 3, 0), waves(40, 31, 3, 0.4)},
        {"anticorrelated", waves(32, 32, 1, 0), inverted(waves(32, 32, 1, 0))},
        {"nearly flat", noise(24, 24, 1, 3, 0.9f, 0.9001f), noise(24, 24, 1, 4, 0.9f, 0.9001f)},
        {"black and faint noise", constant(24, 24, 1, 0), noise(24, 24, 1, 5, 0, 2.0f / 255)},
        {"one window", noise(11, 11, 1, 6), noise(11, 11, 1, 7)},
        {"smaller than the window", noise(10, 8, 3, 8), noise(10, 8, 3, 9)},
        {"one row", noise(30, 1, 1, 10), noise(30, 1, 1, 11)},
        {"one pixel", constant(1, 1, 1, 0.2f), constant(1, 1, 1, 0.7f)}};
    for (const Row& r : rows) {
      CAPTURE(r.name);
      CHECK(std::abs(ssim(r.a, r.b) - direct_ssim(r.a, r.b)) < 1e-9);
    }
  }

  TEST_CASE("SSIM of constants is the luminance term; of a picture with itself 1; of its negative below 0") {
    const Image a = constant(20, 20, 3, 0.25f), b = constant(20, 20, 3, 0.75f);
    const double expected = (2 * 0.25 * 0.75 + 1e-4) / (0.25 * 0.25 + 0.75 * 0.75 + 1e-4);
    CHECK(ssim(a, b) == doctest::Approx(expected).epsilon(1e-9));
    const Image same = waves(50, 40, 3, 0);
    CHECK(ssim(same, same) == doctest::Approx(1).epsilon(1e-12));
    CHECK(ssim(constant(20, 20, 3, 0), constant(20, 20, 3, 0)) == 1.0);
    const Image steep = noise(40, 40, 1, 12);
    CHECK(ssim(steep, inverted(steep)) < -0.5);
  }

  TEST_CASE("MS-SSIM equals its definition at every number of scales a picture allows") {
    struct Row {
      int w, h, scales;
    };
    for (const Row& r : {Row{176, 180, 5}, Row{175, 176, 4}, Row{90, 88, 4}, Row{87, 60, 3}, Row{22, 40, 2},
                         Row{21, 40, 1}, Row{9, 12, 1}}) {
      CAPTURE(r.w);
      CAPTURE(r.h);
      const Image a = waves(r.w, r.h, 1, 0), b = waves(r.w, r.h, 1, 0.3);
      const MsSsim got = ms_ssim_detail(a, b);
      CHECK(got.scales == r.scales);
      CHECK_FALSE(got.clamped);
      CHECK(std::abs(got.value - direct_ms_ssim(a, b, r.scales)) < 1e-9);
    }
  }

  TEST_CASE("a negative factor of MS-SSIM becomes 0 and is reported, never NaN") {
    const Image a = noise(64, 64, 3, 13);
    const MsSsim got = ms_ssim_detail(a, inverted(a));
    CHECK(got.value == 0.0);
    CHECK(got.clamped);
    CHECK(ms_ssim(a, a) == doctest::Approx(1).epsilon(1e-12));
  }

  TEST_CASE("every metric is symmetric") {
    const Image a = waves(180, 177, 3, 0), b = noise(180, 177, 3, 14);
    CHECK(psnr(a, b) == psnr(b, a));
    CHECK(ssim(a, b) == doctest::Approx(ssim(b, a)).epsilon(1e-14));
    CHECK(ms_ssim(a, b) == doctest::Approx(ms_ssim(b, a)).epsilon(1e-12));
  }

  TEST_CASE("a non-finite pixel is never hidden") {
    Image a = waves(64, 64, 1, 0);
    const Image b = a;
    a.data[100] = std::numeric_limits<float>::quiet_NaN();
    CHECK(std::isnan(psnr(a, b)));
    CHECK(std::isnan(ssim(a, b)));
    CHECK(std::isnan(ms_ssim(a, b)));
  }

  TEST_CASE("pictures of different shapes are refused by name") {
    CHECK_THROWS_WITH_AS(ssim(Image(4, 5, 3), Image(5, 4, 3)),
                         "SSIM: the two pictures cannot be compared\n"
                         "  expected: two pictures of one shape, not empty\n"
                         "  got:      4x5 with 3 channels and 5x4 with 3 channels",
                         Error);
    CHECK_THROWS_AS(psnr(Image(), Image()), Error);
  }

  TEST_CASE("left-out pixels: the rest as if they were not there, whatever they hold") {
    const Image a = waves(40, 36, 3, 0), b = waves(40, 36, 3, 0.2);
    PixelMask none(40, 36), right(40, 36), all(40, 36);
    Image odd = b, left_a(28, 36, 3), left_b = left_a;
    for (int y = 0; y < 36; ++y)
      for (int x = 0; x < 40; ++x) {
        all.set(std::size_t(y) * 40 + std::size_t(x));
        if (x >= 28) right.set(std::size_t(y) * 40 + std::size_t(x));
        for (int c = 0; c < 3; ++c) {
          if (x >= 28) odd.pixel(x, y)[c] = 0.3f * float(c);
          if (x < 28) left_a.pixel(x, y)[c] = a.pixel(x, y)[c];
          if (x < 28) left_b.pixel(x, y)[c] = b.pixel(x, y)[c];
        }
      }
    CHECK(psnr(a, b, none) == psnr(a, b));
    CHECK(ssim(a, b, none) == ssim(a, b));
    CHECK(ms_ssim(a, b, none) == ms_ssim(a, b));
    CHECK(psnr(a, odd, right) == doctest::Approx(psnr(left_a, left_b)));
    CHECK(ssim(a, odd, right) == doctest::Approx(ssim(left_a, left_b)));
    CHECK(ms_ssim(a, odd, right) == doctest::Approx(ms_ssim(left_a, left_b)));
    for (const auto metric :
         {static_cast<double (*)(const Image&, const Image&, const PixelMask&)>(psnr),
          static_cast<double (*)(const Image&, const Image&, const PixelMask&)>(ssim),
          static_cast<double (*)(const Image&, const Image&, const PixelMask&)>(ms_ssim)}) {
      CHECK(metric(a, b, right) == doctest::Approx(metric(a, odd, right)).epsilon(1e-9));
      CHECK(std::isnan(metric(a, b, all)));
      CHECK_THROWS_AS(metric(a, b, PixelMask(39, 36)), Error);
    }
    PixelMask middle(40, 36);  // no window of SSIM is left of the rows beside it
    for (int x = 0; x < 40; ++x)
      for (const int y : {8, 18, 28}) middle.set(std::size_t(y) * 40 + std::size_t(x));
    CHECK(std::isfinite(psnr(a, b, middle)));
    CHECK(std::isnan(ssim(a, b, middle)));
    CHECK(std::isnan(ms_ssim(a, b, middle)));
  }
}

}  // namespace
}  // namespace splinevox
