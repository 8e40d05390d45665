// SPDX-License-Identifier: Apache-2.0
#include "train/effects/gains_where.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

using namespace splinevox;

namespace {

constexpr int kSize = 64, kPictures = 12;
const Vec3 kWhite{1, 1, 1};

/// Pictures of a textured square on nothing, each pixel times gain(picture, x, y), beside what a fit shows of
/// them: the square without gains.
struct Film {
  std::vector<Frame> frames;
  std::vector<Image> shown;
};

Film film_of(const std::function<double(int picture, int x, int y)>& gain, double noise = 0.02) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, noise);
  Film film;
  for (int p = 0; p < kPictures; ++p) {
    Image16 image{kSize, kSize, std::vector<std::uint16_t>(std::size_t(4) * kSize * kSize, 0)};
    Image shown(kSize, kSize, 3);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const bool there = x >= 8 && x < 56 && y >= 8 && y < 56;
        const std::size_t i = std::size_t(4) * (std::size_t(y) * kSize + x);
        image.rgba[i + 3] = there ? 65535 : 0;
        for (int c = 0; c < 3; ++c) {
          const double value = 0.3 + 0.2 * std::sin(0.7 * x + c) * std::cos(0.5 * y);
          shown.pixel(x, y)[c] = there ? float(value) : 1.0f;
          const double seen = std::clamp(value * gain(p, x, y) + normal(random), 0.0, 1.0);
          image.rgba[i + std::size_t(c)] = std::uint16_t(std::lround(65535 * seen));
        }
      }
    Frame frame;
    frame.image = std::move(image);
    film.frames.push_back(std::move(frame));
    film.shown.push_back(std::move(shown));
  }
  return film;
}

double explained_share(const Film& film) { return whole_share(film.frames, kWhite, film.shown, 1); }
double drift(int picture) { return 1 + 0.25 * std::sin(picture); }

}  // namespace

TEST_SUITE("train/gains_where") {
  TEST_CASE("an exposure that drifts changes pictures as a whole, noise does not") {
    CHECK(explained_share(film_of([](int p, int, int) { return drift(p); })) > 0.97);
    CHECK(explained_share(film_of([](int, int, int) { return 1.0; })) < 0.5);
  }
  TEST_CASE("in a dark scene pictures are compared as in a bright one") {
    const Vec3 black;
    const Film bright = film_of([](int p, int, int) { return drift(p); });
    Film dark = bright;
    for (Frame& f : dark.frames) {
      Image16 image = f.image.unpacked();
      for (std::size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3) image.rgba[i] = std::uint16_t(std::lround(0.01 * image.rgba[i]));
      f.image = image;
    }
    for (Image& shown : dark.shown)
      for (float& v : shown.data) v *= 0.01f;
    CHECK(whole_share(dark.frames, black, dark.shown, 0.01f) ==
          doctest::Approx(whole_share(bright.frames, black, bright.shown, 1)).epsilon(0.01));
    CHECK(whole_share(dark.frames, black, dark.shown, 1) == 0);
    for (int p = 0; p < kPictures; ++p)
      dark.frames[std::size_t(p)].camera_id = p % 2;  // of whose pictures the exposure drifts
    CHECK(cameras_spread(dark.frames, black, dark.shown, 0.01f).drift > 0.1);
    CHECK(cameras_spread(dark.frames, black, dark.shown, 1).drift == 0);
  }
  TEST_CASE("a highlight that goes by changes a part of each picture") {
    const auto highlight = [](int p, int x, int y) {
      return 1 + std::exp(-(std::pow(x - 5.0 * p, 2) + std::pow(y - 32, 2)) / 200);
    };
    CHECK(explained_share(film_of(highlight)) < 0.8);
    const auto both = [&](int p, int x, int y) { return drift(p) * (1 + 0.3 * (highlight(p, x, y) - 1)); };
    CHECK(explained_share(film_of(both)) > explained_share(film_of(highlight)));
  }
  TEST_CASE("something small that moves hides no drift") {
    const auto ball = [](int p, int x, int y) {
      return std::hypot(x - 12 - 3 * p, y - 30) < 4 ? 0.2 : drift(p);
    };
    CHECK(explained_share(film_of(ball)) > 0.95);
  }
  TEST_CASE("cameras that differ are apart, as far as they are, and chance is not") {
    const auto of_rig = [](const std::function<double(int camera, int picture)>& gain, int cameras = 4) {
      Film film = film_of([&](int p, int, int) { return gain(p % cameras, p); });
      for (int p = 0; p < kPictures; ++p) film.frames[std::size_t(p)].camera_id = p % cameras;
      return cameras_spread(film.frames, kWhite, film.shown, 1);
    };
    const auto of_camera = [](int camera) { return std::exp(0.1 * (camera % 2 ? 1 : -1)); };
    const double sd = 0.1 * std::sqrt(4.0 / 3);
    const CameraSpread steady = of_rig([&](int c, int) { return of_camera(c); });
    CHECK(steady.apart == doctest::Approx(sd).epsilon(0.03));
    CHECK(steady.drift < 0.01);
    CHECK(of_rig([&](int c, int p) { return of_camera(c) * (1 + 0.02 * std::sin(5.0 * p)); }).apart ==
          doctest::Approx(sd).epsilon(0.1));
    const CameraSpread drifting = of_rig([](int, int p) { return drift(p); });
    CHECK(drifting.apart == 0);
    double squares = 0, sum = 0;
    for (int p = 0; p < kPictures; ++p) {
      sum += std::log(drift(p)) / kPictures;
      squares += std::pow(std::log(drift(p)), 2) / kPictures;
    }
    CHECK(drifting.drift == doctest::Approx(std::sqrt(squares - sum * sum)).epsilon(0.15));
    CHECK(of_rig([&](int c, int) { return of_camera(c); }, 1).apart == 0);
  }
  TEST_CASE("what masks ignore hides no drift") {
    // A third of each picture shows somebody who passes by.
    Film film = film_of([](int p, int x, int) { return x < 26 ? 0.4 + 0.1 * (p % 7) : drift(p); });
    CHECK(explained_share(film) < 0.9);
    for (Frame& f : film.frames) {
      f.ignored = PixelMask(kSize, kSize);
      for (int i = 0; i < kSize * kSize; ++i)
        if (i % kSize < 26) f.ignored.set(std::size_t(i));
    }
    CHECK(explained_share(film) > 0.97);
  }
  TEST_CASE("what moves and is shown in a wrong place sets no cameras apart") {
    Film film = film_of([](int p, int x, int y) { return std::hypot(x - 12 - 3 * p, y - 30) < 8 ? 0.2 : 1; });
    for (int p = 0; p < kPictures; ++p) film.frames[std::size_t(p)].camera_id = p % 4;
    CHECK(cameras_spread(film.frames, kWhite, film.shown, 1).apart < 0.01);
    CHECK(cameras_spread(film.frames, kWhite, film.shown, 1).drift < 0.01);
  }
  TEST_CASE("without pictures, or with nothing in them, there is no share") {
    CHECK(cameras_spread({}, kWhite, {}, 1).apart == 0);
    CHECK(cameras_spread({}, kWhite, {}, 1).drift == 0);
    CHECK(explained_share({}) == 0);
    Film film = film_of([](int, int, int) { return 1.0; });
    for (Frame& f : film.frames)
      f.image = Image16{kSize, kSize, std::vector<std::uint16_t>(std::size_t(4) * kSize * kSize, 0)};
    CHECK(explained_share(film) == 0);
  }
  TEST_CASE("black in a fit's picture is no ratio") {
    Film film = film_of([](int p, int, int) { return drift(p); });
    for (Image& shown : film.shown)
      for (int x = 8; x < 24; ++x)
        for (int y = 8; y < 56; ++y)
          for (int c = 0; c < 3; ++c) shown.pixel(x, y)[c] = 0;
    CHECK(explained_share(film) > 0.97);
  }
}
