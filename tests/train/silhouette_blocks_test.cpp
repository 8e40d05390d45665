// SPDX-License-Identifier: Apache-2.0
#include "train/silhouette_blocks.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <utility>

using namespace splinevox;

namespace {

/// A frame of a picture.
Frame frame_of(Picture picture) {
  Frame frame;
  frame.image = std::move(picture);
  return frame;
}

Picture dotted(int width, int height, double share, unsigned seed) {
  std::mt19937 random(seed);
  Image16 image{width, height, std::vector<std::uint16_t>(std::size_t(4) * width * height, 0)};
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    if (random() < share * 4294967296.0) image.rgba[i] = 257;
  return image;
}

/// Blocks to the nearest that shows something or is ignored in part, along the longer axis.
int distance(const Frame& frame, int x, int y) {
  const Picture& picture = frame.image;
  int least = 1 << 20;
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u)
      if (picture.pixel(u, v)[3] > 0 || frame.ignored.test(u, v))
        least = std::min(least, std::max(std::abs(u / 2 - x), std::abs(v / 2 - y)));
  return least;
}

void check_blocks(const Frame& frame) {
  const int width = frame.image.width, height = frame.image.height, w = (width + 1) / 2, h = (height + 1) / 2;
  const auto is_usable = [&](int x, int y) {
    for (int k = 0; k < 4; ++k)
      if (!frame.ignored.test(std::min(2 * x + k % 2, width - 1), std::min(2 * y + k / 2, height - 1)))
        return true;
    return false;
  };
  for (const int ring : {0, 1, 4}) {
    const SilhouetteBlocks blocks(frame, ring);
    std::vector<std::uint32_t> near, usable;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const int d = distance(frame, x, y);
        const auto block = std::uint32_t(y * w + x);
        if (is_usable(x, y)) usable.push_back(block);
        if (d <= ring && is_usable(x, y)) near.push_back(block);
        for (const double margin : {0.0, 3.5, 4.0, 60.0, 254.9})
          CHECK(blocks.clear(block, margin) == (d > margin));
      }
    REQUIRE(blocks.near_count() == near.size());
    for (std::uint32_t k = 0; k < near.size(); ++k) CHECK(blocks.near(k) == near[k]);
    REQUIRE(blocks.usable_count() == usable.size());
    for (std::uint32_t k = 0; k < usable.size(); ++k) CHECK(blocks.usable(k) == usable[k]);
  }
}

TEST_SUITE("train/silhouette_blocks") {
  TEST_CASE("near blocks and clear distances are those that all pixels give") {
    unsigned seed = 0;
    for (const auto& [width, height] : {std::pair{150, 40}, {131, 17}, {1, 1}, {128, 9}, {258, 6}})
      for (const double share : {0.0, 0.0005, 0.01, 0.5}) {
        for (const bool ignoring : {false, true}) {
          Frame frame = frame_of(dotted(width, height, share, ++seed));
          if (ignoring) {
            frame.ignored = PixelMask(width, height);
            for (int i = 0; i < width * height; ++i)
              if (i % width < 7 || i % 31 == 0) frame.ignored.set(std::size_t(i));
          }
          check_blocks(frame);
        }
      }
  }

  TEST_CASE("every block of an opaque picture is near, none is clear, and none of a cut one is forgotten") {
    Picture picture = Image16{5, 3, std::vector<std::uint16_t>(60, 65535)};
    const SilhouetteBlocks all(frame_of(picture), 4);
    CHECK(all.near_count() == 6);
    CHECK(all.near(5) == 5);
    CHECK_FALSE(all.clear(0, 4));
    std::vector<bool> cut(15, true);
    cut[14] = false;
    picture.cut(cut);
    CHECK_FALSE(picture.opaque());
    CHECK(picture.pixel(0)[3] == 0);
    CHECK(picture.pixel(0)[0] == 65535);
    const SilhouetteBlocks few(frame_of(picture), 0);
    CHECK(few.near_count() == 1);
    CHECK(few.near(0) == 5);
    CHECK(few.clear(0, 1));
    picture.cut({});
    CHECK(picture.opaque());
    CHECK(picture == Picture(picture.unpacked()));
  }
}

}  // namespace
