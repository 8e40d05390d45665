// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "core/half.hpp"
#include "data/expect_error.hpp"
#include "data/pictures/exr.hpp"
#include "math/srgb.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;

/// Training pictures f0, f1, ... of one ending.
struct Set {
  TempFolder folder;
  std::string path(int i, const std::string& end = "exr") const {
    std::string name = folder.str();
    name += "/f";
    name += std::to_string(i);
    return name += "." + end;
  }
  void frames(int count, const std::string& end = "exr") const {
    std::vector<std::string> frames;
    for (int i = 0; i < count; ++i)
      frames.push_back(frame_text(fs::path(path(i, end)).filename().string(), std::to_string(i),
                                  matrix_text(orbit_matrix(i))));
    write_text(folder.path() / "transforms_train.json", transforms_text(frames, "\"camera_angle_x\": 0.8,"));
  }
  Dataset load(const DatasetRules& rules = {}) const { return load_dataset(folder.str(), {.rules = rules}); }
};

Image filled(int channels, std::vector<float> pixel) {
  Image image(4, 4, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = pixel[i % pixel.size()];
  return image;
}

std::array<float, 4> first_pixel(const Dataset& data, std::size_t frame = 0) {
  std::array<float, 4> p = data.find("train")->frames[frame].image.rgba(0);
  for (float& v : p) v /= 65535;
  return p;
}

bool notes_have(const Dataset& data, const std::string& part) {
  for (const std::string& note : data.notes)
    if (note.find(part) != note.npos) return true;
  return false;
}

constexpr double kHalfStep = 6e-4;  ///< relative, of a half

/// A picture of 4 x 4, red in its left column and blue in all others, whose mask is white in that column: of
/// floats, or of 16 bits.
void write_red_column(const Set& set, const std::string& end, float red) {
  Image image = filled(3, {0, 0, 1});
  TinyPng png{4, 4, 16, PngKind::rgb, {}}, mask{4, 4, 8, PngKind::grey, {}};
  for (int i = 0; i < 16; ++i) {
    const bool left = i % 4 == 0;
    if (left) image.data[std::size_t(3 * i)] = red;
    if (left) image.data[std::size_t(3 * i + 2)] = 0;
    for (const float v : {left ? red : 0, 0.0f, left ? 0 : 1.0f}) {
      const int bits = int(65535 * std::min(v, 1.0f));
      png.rows.push_back(std::uint8_t(bits >> 8));
      png.rows.push_back(std::uint8_t(bits & 255));
    }
    mask.rows.push_back(left ? 255 : 0);
  }
  write_png(set.folder.path() / "masks/f0.png", mask);
  if (end == "exr")
    write_exr(set.path(0), {{"", image, {}}});
  else
    write_png(set.path(0, end), png);
  set.frames(1, end);
}

/// Whether two pictures show the same: what is invisible has any colour.
bool look_alike(const Picture& a, const Picture& b) {
  for (std::size_t i = 0; i < a.pixels(); ++i)
    if (a.rgba(i)[3] != b.rgba(i)[3] || (a.rgba(i)[3] > 0 && a.rgba(i) != b.rgba(i))) return false;
  return a.pixels() == b.pixels();
}

TEST_SUITE("data/linear") {
  TEST_CASE("every half comes back, and others become the nearest") {
    for (std::uint16_t h = 0; h <= 0x7bff; ++h) CHECK(to_half(from_half(h)) == h);
    CHECK(from_half(kHalfOne) == 1);
    CHECK(from_half(0x7bff) == kLargestHalf);
    for (std::uint16_t h = 0; h < 0x7bff; h = std::uint16_t(h + 7)) {
      const float lo = from_half(h), hi = from_half(std::uint16_t(h + 1)), middle = lo + (hi - lo) / 2;
      CHECK(to_half(std::nextafter(middle, lo)) == h);
      CHECK(to_half(std::nextafter(middle, hi)) == h + 1);
      CHECK(to_half(middle) == (h % 2 == 0 ? h : h + 1));
    }
  }

  TEST_CASE("OpenEXR is light: the curve of sRGB, beyond 1 too, alpha taken out, nothing below 0") {
    const Set set;
    write_exr(set.path(0), {{"", filled(4, {1.25f, 0.1f, -0.5f, 0.5f}), {}}});
    write_exr(set.path(1), {{"", filled(3, {8, 0.5f, 0.002f}), {}}});
    set.frames(2);
    const Dataset data = set.load();
    const auto a = first_pixel(data), b = first_pixel(data, 1);
    CHECK(a[0] == doctest::Approx(linear_to_srgb(2.5f)).epsilon(kHalfStep));
    CHECK(a[1] == doctest::Approx(linear_to_srgb(0.2f)).epsilon(kHalfStep));
    CHECK(a[2] == 0);
    CHECK(a[3] == 0.5f);
    CHECK(b[0] == doctest::Approx(linear_to_srgb(8)).epsilon(kHalfStep));
    CHECK(b[2] == doctest::Approx(0.002 * 12.92).epsilon(kHalfStep));
    CHECK(b[3] == 1);
    CHECK(data.has_alpha);
    CHECK(data.find("train")->frames[1].image.opaque());
    CHECK(data.find("train")->frames[1].image.pixel(0)[0] == 65535);
    CHECK(notes_have(data, "2 of 2 pictures are taken as linear light"));
    CHECK(notes_have(data, "1 of 2 pictures are below 0 or not finite in places"));
    const Dataset display = set.load({.transfer = "srgb"});
    CHECK(first_pixel(display)[0] == 2.5f);
    CHECK(notes_have(display, "2 of 2 pictures hold floats that are taken as a screen shows them"));
    CHECK(display.fingerprint != data.fingerprint);
    expect_error([&] { set.load({.transfer = "gamma"}); }, {"--transfer", "srgb or linear", "gamma"});
  }

  TEST_CASE("a block of linear pixels is averaged as light") {
    const Set set;
    Image image = filled(3, {0, 0, 0});
    for (std::size_t i = 0; i < 6; ++i) image.data[i] = 1;  // two of the first block's four pixels
    image.pixel(1, 0)[0] = 1;
    write_exr(set.path(0), {{"", image, {}}});
    set.frames(1);
    const Dataset data = load_dataset(set.folder.str(), {.downscale = 2});
    CHECK(first_pixel(data)[0] == doctest::Approx(linear_to_srgb(0.5f)).epsilon(kHalfStep));
  }

  TEST_CASE("a block of premultiplied pixels has no dark rim; a plain one is averaged as D-NeRF does it") {
    const Set set;
    Image image = filled(4, {0, 0, 0, 0});
    image.data[0] = image.data[3] = 1;  // one of the first block's four pixels
    write_exr(set.path(0), {{"", image, {}}});
    set.frames(1);
    LoadOptions options;
    options.downscale = 2;
    const auto rim = first_pixel(load_dataset(set.folder.str(), options));
    CHECK(rim[0] == doctest::Approx(1).epsilon(kHalfStep));
    CHECK(rim[1] == 0);
    CHECK(rim[3] == doctest::Approx(0.25));
    TinyPng png{4, 4, 8, PngKind::rgba, Bytes(64, 0)};
    png.rows[0] = png.rows[3] = 255;
    write_png(set.path(0, "png"), png);
    set.frames(1, "png");
    const auto plain = first_pixel(load_dataset(set.folder.str(), options));
    CHECK(plain[0] == doctest::Approx(0.25).epsilon(1e-4));
    CHECK(plain[3] == doctest::Approx(0.25).epsilon(1e-4));
  }

  TEST_CASE("what a mask leaves out lends no colour to the rim of the subject") {
    for (const std::string end : {"exr", "png"}) {
      CAPTURE(end);
      const Set set;
      write_red_column(set, end, 1);
      LoadOptions options;
      options.downscale = 2;
      options.rules.masks = "subject";
      const auto rim = first_pixel(load_dataset(set.folder.str(), options));
      CHECK(rim[0] == doctest::Approx(1).epsilon(kHalfStep));
      CHECK(rim[2] == 0);
      CHECK(rim[3] == doctest::Approx(0.5).epsilon(1e-4));
    }
  }

  TEST_CASE("what convert cuts out keeps its numbers: light stays light, beyond 1 and with all its bits") {
    using Words = std::pair<std::string, std::string>;
    for (const auto& [end, transfer] :
         {Words{"exr", ""}, {"exr", "linear"}, {"exr", "srgb"}, {"png", "linear"}}) {
      CAPTURE(end);
      CAPTURE(transfer);
      const Set set;
      const TempFolder out;
      write_red_column(set, end, end == "exr" ? 2.5f : 0.3f);
      const DatasetRules rules{.masks = "subject", .transfer = transfer};
      const Dataset was = set.load(rules);
      convert_dataset(set.folder.str(), out.str() + "/new", {}, {.rules = rules});
      const Dataset is = load_dataset(out.str() + "/new", {.rules = {.transfer = transfer}});
      CHECK(look_alike(was.find("train")->frames[0].image, is.find("train")->frames[0].image));
      const fs::path picture = out.path() / "new/train" / ("f0." + end);
      REQUIRE(fs::exists(picture));
      if (end == "png") CHECK(read_png_header(picture).bits == 16);
    }
  }

  TEST_CASE("layers: the one with colours, else Combined, else the one that is named, else an error") {
    const Set set;
    const std::vector<std::string> rgb = {"R", "G", "B"};
    const auto layer = [&](const char* name, float v) { return ExrLayer{name, filled(3, {v, v, v}), rgb}; };
    set.frames(1);
    const auto value = [&](const DatasetRules& rules) { return first_pixel(set.load(rules))[0]; };
    write_exr(set.path(0), {layer("beauty", 0.5f), {"depth", filled(1, {7}), {}}});
    CHECK(value({.transfer = "srgb"}) == 0.5f);
    write_exr(set.path(0), {layer("V.Combined", 0.25f), layer("V.Diffuse", 0.5f)});
    CHECK(value({.transfer = "srgb"}) == 0.25f);
    CHECK(value({.transfer = "srgb", .layer = "V.Diffuse"}) == 0.5f);
    expect_error([&] { set.load({.layer = "V.Gloss"}); },
                 {"f0.exr", "no layer of colours named 'V.Gloss'", "V.Combined, V.Diffuse"});
    write_exr(set.path(0), {layer("a", 0.25f), layer("b", 0.5f)});
    expect_error([&] { set.load(); }, {"several layers hold colours", "--layer", "a, b"});
    write_exr(set.path(0), {{"depth", filled(1, {7}), {}}});
    expect_error([&] { set.load(); }, {"f0.exr", "holds no colours"});
    write_exr(set.path(0), {{"", filled(1, {0.75f}), {"Y"}}});
    CHECK(value({.transfer = "srgb"}) == 0.75f);
    const ExrLayer normals{"N", filled(3, {0, 1, 0}), {"X", "Y", "Z"}},
        flow{"uv", filled(2, {1, 1}), {"X", "Y"}};
    write_exr(set.path(0), {layer("beauty", 0.5f), normals, flow});
    CHECK(value({.transfer = "srgb"}) == 0.5f);
    write_exr(set.path(0), {normals, flow});
    expect_error([&] { set.load(); }, {"f0.exr", "holds no colours"});
    write_exr(set.path(0), {{"", filled(2, {0.75f, 9}), {"Y", "Z"}}});  // grey and depth
    CHECK(value({.transfer = "srgb"}) == 0.75f);
    write_exr(set.path(0), {{"", filled(2, {9, 0.75f}), {"R", "Y"}}});
    CHECK(value({.transfer = "srgb"}) == 0.75f);
  }

  TEST_CASE("a damaged OpenEXR file is named with its frame") {
    const Set set;
    write_exr(set.path(0), {{"", filled(3, {1, 1, 1}), {}}});
    set.frames(1);
    const auto size = fs::file_size(set.path(0));
    fs::resize_file(set.path(0), size - 20);
    expect_error([&] { set.load(); }, {"f0.exr (train, frame 0)", "damaged or cut off"});
    fs::resize_file(set.path(0), 40);
    expect_error([&] { set.load(); }, {"f0.exr (train, frame 0)", "header is damaged"});
  }

  TEST_CASE("whole numbers are what a screen shows, unless the user says that they are light") {
    const Set set;
    write_png(set.path(0, "png"), {2, 1, 16, PngKind::rgb, {0x80, 0, 0, 0, 0xff, 0xff, 0, 0, 0, 0, 0, 0}});
    set.frames(1, "png");
    CHECK(first_pixel(set.load())[0] == doctest::Approx(32768 / 65535.0));
    const Dataset light = set.load({.transfer = "linear"});
    CHECK(first_pixel(light)[0] == doctest::Approx(linear_to_srgb(0.5f)).epsilon(1e-4));
    CHECK(first_pixel(light)[2] == 1);
    CHECK_FALSE(light.find("train")->frames[0].image.layout().half);
    CHECK(notes_have(light, "1 of 1 pictures are taken as linear light"));
  }

  TEST_CASE("pictures of floats are the same from the cache") {
    const Set set;
    for (int i = 0; i < 80; ++i)
      write_exr(set.path(i), {{"", filled(4, {0.1f * float(i), 2, -1, i % 2 == 0 ? 1.0f : 0.5f}), {}}});
    set.frames(80);
    const Dataset memory = set.load();
    LoadOptions less{.room = [](const Dataset&) { return 6e3; }, .cache = set.folder.str() + "/cache"};
    for (int again = 0; again < 2; ++again) {
      Dataset file;
      tbb::task_arena(2).execute([&] { file = load_dataset(set.folder.str(), less); });
      CHECK(file.pictures_in_files > 0);
      CHECK(file.fingerprint == memory.fingerprint);
      for (std::size_t f = 0; f < 80; ++f)
        CHECK(file.find("train")->frames[f].image == memory.find("train")->frames[f].image);
      CHECK(notes_have(file, "80 of 80 pictures are below 0 or not finite in places"));
    }
  }
}

}  // namespace
