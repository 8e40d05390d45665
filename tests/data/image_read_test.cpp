// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <vector>

#include "data/expect_error.hpp"
#include "data/pictures/picture_header.hpp"
#include "data/pictures/pictures.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using Pixel = std::array<int, 4>;

Pixel pixel_of(const Image16& image, int x, int y) {
  const std::uint16_t* p = image.pixel(x, y);
  return {p[0], p[1], p[2], p[3]};
}

Image16 round_trip(const TempFolder& folder, const TinyPng& png) {
  write_png(folder.path() / "a.png", png);
  return read_png(folder.path() / "a.png");
}

TEST_SUITE("data/image_read") {
  TEST_CASE("what has 8 bits is kept in 8, and every picture is what it was") {
    for (const std::uint16_t step : {1, 257}) {
      Image16 image{16, 16, {}};
      for (int i = 0; i < 4 * 16 * 16; ++i) image.rgba.push_back(std::uint16_t(step * (i % 256)));
      const Picture picture = image;
      CHECK(picture.unpacked().rgba == image.rgba);
      CHECK(picture.pixel(5, 3)[2] == image.pixel(5, 3)[2]);
      CHECK(picture.pixel(3 * 16 + 5) == picture.pixel(5, 3));
      CHECK(picture == Picture(picture.unpacked()));
      CHECK(picture != Picture(Image16{16, 16, std::vector<std::uint16_t>(4 * 16 * 16, 257)}));
    }
    CHECK_FALSE(Picture().has_values());
    CHECK_FALSE(Picture(Image16{2, 2, {}}).has_values());
    CHECK(Picture(Image16{2, 2, {}}).unpacked().rgba.empty());
  }
  TEST_CASE("8-bit RGBA becomes 257 v, straight: colour under alpha is kept as stored") {
    const TempFolder folder;
    const Image16 image = round_trip(folder, {2, 1, 8, PngKind::rgba, {200, 100, 50, 128, 255, 1, 7, 0}});
    CHECK(image.width == 2);
    CHECK(image.height == 1);
    CHECK(pixel_of(image, 0, 0) == Pixel{200 * 257, 100 * 257, 50 * 257, 128 * 257});
    CHECK(pixel_of(image, 1, 0) == Pixel{65535, 257, 7 * 257, 0});
  }

  TEST_CASE("16-bit RGBA keeps every bit") {
    const TempFolder folder;
    const Image16 image =
        round_trip(folder, {1, 1, 16, PngKind::rgba, {0x12, 0x34, 0xff, 0xfe, 0x00, 0x01, 0x80, 0x00}});
    CHECK(pixel_of(image, 0, 0) == Pixel{0x1234, 0xfffe, 1, 0x8000});
  }

  TEST_CASE("pictures without alpha are opaque") {
    const TempFolder folder;
    CHECK(pixel_of(round_trip(folder, {1, 1, 8, PngKind::rgb, {1, 2, 3}}), 0, 0) ==
          Pixel{257, 514, 771, 65535});
    CHECK(pixel_of(round_trip(folder, {1, 1, 16, PngKind::rgb, {1, 2, 3, 4, 5, 6}}), 0, 0) ==
          Pixel{0x0102, 0x0304, 0x0506, 65535});
    CHECK(pixel_of(round_trip(folder, {1, 1, 8, PngKind::grey, {9}}), 0, 0) ==
          Pixel{2313, 2313, 2313, 65535});
    CHECK(pixel_of(round_trip(folder, {1, 1, 16, PngKind::grey, {9, 8}}), 0, 0) ==
          Pixel{0x0908, 0x0908, 0x0908, 65535});
  }

  TEST_CASE("grey of fewer bits spans the whole range") {
    const TempFolder folder;
    const Image16 one = round_trip(folder, {2, 1, 1, PngKind::grey, {0x40}});
    CHECK(pixel_of(one, 0, 0) == Pixel{0, 0, 0, 65535});
    CHECK(pixel_of(one, 1, 0) == Pixel{65535, 65535, 65535, 65535});
    const Image16 four = round_trip(folder, {2, 1, 4, PngKind::grey, {0x5f}});
    CHECK(pixel_of(four, 0, 0) == Pixel{0x5555, 0x5555, 0x5555, 65535});
    CHECK(pixel_of(four, 1, 0) == Pixel{65535, 65535, 65535, 65535});
  }

  TEST_CASE("grey with alpha, and colour keys, give alpha") {
    const TempFolder folder;
    CHECK(pixel_of(round_trip(folder, {1, 1, 8, PngKind::grey_alpha, {10, 20}}), 0, 0) ==
          Pixel{2570, 2570, 2570, 5140});
    const Image16 keyed =
        round_trip(folder, {2, 1, 8, PngKind::rgb, {1, 2, 3, 4, 5, 6}, {}, {0, 1, 0, 2, 0, 3}});
    CHECK(pixel_of(keyed, 0, 0)[3] == 0);
    CHECK(pixel_of(keyed, 1, 0) == Pixel{1028, 1285, 1542, 65535});
  }

  TEST_CASE("a palette is looked up, with its alpha") {
    const TempFolder folder;
    const Image16 image =
        round_trip(folder, {2, 1, 8, PngKind::palette, {1, 0}, {10, 20, 30, 40, 50, 60}, {255, 77}});
    CHECK(pixel_of(image, 0, 0) == Pixel{40 * 257, 50 * 257, 60 * 257, 77 * 257});
    CHECK(pixel_of(image, 1, 0) == Pixel{10 * 257, 20 * 257, 30 * 257, 65535});
  }

  TEST_CASE("a tRNS chunk before the pixels is alpha, before any is decoded") {
    const TempFolder folder;
    const fs::path path = folder.path() / "a.png";
    const TinyPng palette{2, 1, 8, PngKind::palette, {1, 0}, {10, 20, 30, 40, 50, 60}, {255, 77}},
        grey{2, 1, 8, PngKind::grey, {1, 0}, {}, {0, 1}}, rgb{1, 1, 8, PngKind::rgb, {1, 2, 3}},
        plain{2, 1, 8, PngKind::palette, {1, 0}, {10, 20, 30, 40, 50, 60}};
    for (const TinyPng& png : {palette, grey, rgb, plain, flat_png(1, 1)}) {
      write_png(path, png);
      const bool alpha = png.kind == PngKind::rgba || !png.trns.empty();
      CHECK(read_png_header(path).alpha == alpha);
      CHECK(data::read_picture_header(path).alpha == alpha);
    }
    write_png(path, palette);
    write_text(folder.path() / "transforms_train.json",
               transforms_text({frame_text("a.png", "0", matrix_text(orbit_matrix(0)))}));
    CHECK(load_dataset(folder.str(), {.pixels = false}).has_alpha);
    data::RawSplit split{"train", "a.json", true, {}};
    split.frames.emplace_back();
    split.frames[0].found = fs::canonical(path);
    CHECK(data::plan_pictures(folder.path(), split, 1).pixel_bytes == std::vector<int>{4});
  }

  TEST_CASE("a tRNS chunk behind the pixels, too many chunks or a false length counts for nothing") {
    const TempFolder folder;
    const fs::path path = folder.path() / "a.png";
    const auto alpha_after = [&](const Bytes& chunks) {
      Bytes png = png_header(2, 1, 8, PngKind::palette);
      png.insert(png.end(), chunks.begin(), chunks.end());
      put_chunk(png, "tRNS", {0});
      write_bytes(path, png);
      return read_png_header(path).alpha;
    };
    Bytes many, pixels, some;
    for (int i = 0; i < 100'000; ++i) put_chunk(many, "tEXt", {});
    put_chunk(pixels, "IDAT", {});
    put_chunk(some, "tEXt", Bytes(70'000, 1));
    CHECK(alpha_after(some));
    CHECK_FALSE(alpha_after(many));
    CHECK_FALSE(alpha_after(pixels));
    for (const std::uint32_t length : {0x7fffffffu, 0xffffffffu, 0xfffffff4u}) {
      Bytes lie;
      put_be32(lie, length);
      for (const char c : {'t', 'E', 'X', 't'}) lie.push_back(std::uint8_t(c));
      CHECK_FALSE(alpha_after(lie));
    }
    write_bytes(path, png_header(2, 1, 8, PngKind::palette));
    CHECK_FALSE(read_png_header(path).alpha);
  }

  TEST_CASE("the area filter averages each channel for itself and rounds to the nearest") {
    Image16 image{2, 2, {10, 0, 0, 65535, 20, 0, 0, 0, 30, 0, 0, 0, 41, 3, 0, 65535}};
    const Image16 small = area_downscale(image, 2);
    CHECK(small.width == 1);
    CHECK(small.height == 1);
    CHECK(pixel_of(small, 0, 0) == Pixel{25, 1, 0, 32768});
    CHECK(area_downscale(image, 1).rgba == image.rgba);
  }

  TEST_CASE("by alpha, what is invisible lends no colour") {
    const Image16 image{2, 2, {60000, 0, 0, 65535, 0, 9, 9, 0, 0, 9, 9, 0, 20000, 0, 30, 21845}};
    CHECK(pixel_of(area_downscale(image, 2, ColourMean::by_alpha), 0, 0) == Pixel{50000, 0, 8, 21845});
    CHECK(area_downscale(image, 1, ColourMean::by_alpha).rgba == image.rgba);
    const Image16 nothing{2, 2, std::vector<std::uint16_t>{7, 7, 7, 0, 7, 7, 7, 0, 7, 7, 7, 0, 7, 7, 7, 0}};
    CHECK(pixel_of(area_downscale(nothing, 2, ColourMean::by_alpha), 0, 0) == Pixel{0, 0, 0, 0});
  }

  TEST_CASE("blocks of the area filter do not mix") {
    Image16 image{4, 2, {}};
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 4; ++x)
        for (int c = 0; c < 4; ++c) image.rgba.push_back(std::uint16_t(x < 2 ? 1000 : 3000));
    const Image16 small = area_downscale(image, 2);
    CHECK(pixel_of(small, 0, 0) == Pixel{1000, 1000, 1000, 1000});
    CHECK(pixel_of(small, 1, 0) == Pixel{3000, 3000, 3000, 3000});
  }

  TEST_CASE("every truncation of a PNG is an error that names the file") {
    const TempFolder folder;
    const Bytes whole = png_bytes(flat_png(5, 3));
    const auto path = folder.path() / "cut.png";
    for (std::size_t n = 0; n < whole.size(); ++n) {
      CAPTURE(n);
      write_bytes(path, Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n)));
      expect_error([&] { read_png(path); }, {"cut.png: the image is"});
    }
    write_bytes(path, whole);
    CHECK(read_png(path).pixels() == 15);
  }

  TEST_CASE("damaged bytes give an error or a whole picture, never a crash") {
    const TempFolder folder;
    const Bytes whole = png_bytes({4, 4, 8, PngKind::palette, Bytes(16, 1), {1, 2, 3, 4, 5, 6}, {9}});
    const auto path = folder.path() / "mutant.png";
    std::mt19937 random(7);
    int refused = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      Bytes bytes = whole;
      for (unsigned k = 0; k < 1 + trial % 3u; ++k) bytes[random() % bytes.size()] = std::uint8_t(random());
      write_bytes(path, bytes);
      try {
        const Image16 image = read_png(path);
        CHECK(image.rgba.size() == image.pixels() * 4);
      } catch (const Error&) {
        ++refused;
      }
    }
    CHECK(refused > 1500);
  }

  TEST_CASE("what is no PNG is named") {
    const TempFolder folder;
    const auto path = folder.path() / "x.png";
    write_bytes(path, {0xff, 0xd8, 0xff, 0xe0, 0, 0});
    expect_error([&] { read_png(path); }, {"x.png: the image is not a PNG", "got:      a JPEG"});
    write_bytes(path, {});
    expect_error([&] { read_png(path); }, {"not a PNG", "an empty file"});
    expect_error([&] { read_png(folder.path()); }, {"this is not a file", "a folder"});
    expect_error([&] { read_png(folder.path() / "none.png"); }, {"none.png: the file does not exist"});
  }

  TEST_CASE("a header that claims too much is refused before anything is allocated") {
    const TempFolder folder;
    const auto path = folder.path() / "bomb.png";
    const auto refuse = [&](std::uint32_t w, std::uint32_t h, int bits, const std::string& part) {
      CAPTURE(w);
      CAPTURE(h);
      write_bytes(path, png_header(w, h, bits, PngKind::rgba));
      expect_error([&] { read_png(path); }, {"bomb.png", part});
      expect_error([&] { read_png_header(path); }, {"bomb.png", part});
    };
    refuse(100000, 100000, 8, "size is out of range");
    refuse(65537, 1, 8, "size is out of range");
    refuse(0, 5, 8, "size is out of range");
    refuse(5, 0, 8, "size is out of range");
    refuse(0xffffffffu, 1, 8, "size is out of range");
    refuse(65536, 65536, 8, "size is out of range");
    refuse(16384, 16384, 8, "claims more pixels than its file can hold");
    refuse(4, 4, 3, "the image is damaged");
    write_bytes(path, png_header(4, 4, 16, PngKind::palette));
    expect_error([&] { read_png(path); }, {"the image is damaged", "type 3 with 16 bits"});
  }

  TEST_CASE("the caller may name the file for the message") {
    expect_error([] { read_png("/nowhere/a.png", "scene/a.png (train, frame 3)"); },
                 {"scene/a.png (train, frame 3): the file does not exist"});
  }
}

}  // namespace
