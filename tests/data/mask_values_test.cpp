// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <array>

#include "data/masked.hpp"

/// What the values of masks mean.
namespace {

using namespace splinevox;
using namespace splinevox::test;

TEST_SUITE("data/masks") {
  TEST_CASE("a mask may be in the alpha, of one colour or of the cut-out picture itself") {
    const auto rgba = [](const auto& colour, const auto& alpha) {
      TinyPng png{kWide, kHigh, 8, PngKind::rgba, {}};
      for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x) {
          for (const int v : colour(x)) png.rows.push_back(std::uint8_t(v));
          png.rows.push_back(std::uint8_t(alpha(x, y)));
        }
      return png;
    };
    using Colour = std::array<int, 3>;
    const auto white = [](int) { return Colour{255, 255, 255}; };
    const auto photo = [](int x) { return Colour{200, 20 * x, 30}; };
    const auto half = [](int x) { return x < 5 ? Colour{255, 255, 255} : Colour{0, 0, 0}; };
    const auto opaque = [](int, int) { return 255; };
    for (const TinyPng& png : {rgba(white, left_half), rgba(photo, left_half)}) {
      const Dataset data = Masked(png).load(with("subject"));
      for (int x = 0; x < kWide; ++x) CHECK(first_frame(data).image.pixel(x, 3)[3] == 257 * left_half(x, 3));
    }
    const auto gone = [](int, int) { return 0; };
    for (const TinyPng& png : {rgba(white, gone), rgba(photo, gone)}) {
      const Masked left(rgba(white, left_half));  // the subject leaves
      write_png(left.folder.path() / ("masks/frame_" + padded(0) + ".png"), png);
      CHECK(first_frame(left.load(with("subject"))).image.pixel(0, 0)[3] == 0);
    }
    const Dataset grey = Masked(rgba(half, opaque)).load(with("subject"));
    CHECK(first_frame(grey).image.pixel(4, 0)[3] == 65535);
    CHECK(first_frame(grey).image.pixel(5, 0)[3] == 0);
    const Masked colours(rgba(photo, opaque));
    const std::string error = colours.error("subject");
    CAPTURE(error);
    CHECK(holds(error, "masks/frame_0000.png"));
    CHECK(holds(error, "the mask has colours"));
    CHECK(holds(error, "a pixel of (200, "));
    const Dataset unused = colours.load({});
    CHECK(notes_with(unused, "They cannot be used: ").size() == 1);
    CHECK(notes_with(unused, "the mask has colours").size() == 1);
  }

  TEST_CASE("0 and 1 are black and white, but not where a second part comes in later") {
    const Masked ones(grey_png([](int x, int) { return x % 2; }));
    CHECK(ones.load(with("subject")).has_alpha);
    for (int i = 5; i < kMasks; ++i)
      write_png(ones.folder.path() / ("masks/frame_" + padded(i) + ".png"),
                grey_png([](int x, int) { return x % 3; }));
    for (const std::string use : {"subject", "moving", "ignore"})
      CHECK(holds(ones.error(use), "the masks seem to be numbers of parts"));
  }
}

}  // namespace
