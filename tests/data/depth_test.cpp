// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "data/expect_error.hpp"
#include "data/layouts.hpp"
#include "data/pictures/exr.hpp"
#include "data/wild.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/data/synth.hpp"

/// Depth maps that transforms files name: how they are read, what they are taken for, what is refused.
namespace {

using namespace splinevox;
using namespace splinevox::test;

constexpr int kMaps = 4;

/// Depth of pixel (x, y) in millimetres; nothing is known of the first one.
int depth_of(int x, int y) { return x + y == 0 ? 0 : 1000 + 100 * x + 10 * y; }

std::vector<double> metres(int wide = kWide, int high = kHigh) {
  std::vector<double> out;
  for (int y = 0; y < high; ++y)
    for (int x = 0; x < wide; ++x) out.push_back(1e-3 * depth_of(x, y));
  return out;
}

Bytes depth_png(int wide = kWide, int high = kHigh) {
  TinyPng png{wide, high, 16, PngKind::grey, {}};
  for (int y = 0; y < high; ++y)
    for (int x = 0; x < wide; ++x) {
      png.rows.push_back(std::uint8_t(depth_of(x, y) >> 8));
      png.rows.push_back(std::uint8_t(depth_of(x, y) & 255));
    }
  return png_bytes(png);
}

/// nerfstudio's layout with a depth map for every picture.
struct Deep {
  TempFolder folder;
  /// @param field  of the file, before its frames
  Deep(const std::string& name, const Bytes& bytes, const std::string& field = "") {
    write_nerfstudio(folder.path(), true_cameras({}, kMaps));
    std::ifstream in(folder.path() / "transforms.json");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::string before = "{\"fl_x\"";
    for (std::size_t at = 0, i = 0; (at = text.find(before, at)) != std::string::npos; ++i) {
      const std::string path = "depth/" + std::to_string(i) + name;
      text.insert(at + 1, "\"depth_file_path\": \"" + path + "\", ");
      if (!bytes.empty()) write_bytes(folder.path() / path, bytes);
    }
    text.insert(1, field);
    write_text(folder.path() / "transforms.json", text);
  }
  Dataset load(const std::string& kind = "", int downscale = 1, bool depth = true) const {
    LoadOptions options;
    options.rules.depth = kind;
    options.downscale = downscale;
    options.depth = depth;
    return load_dataset(folder.str(), options);
  }
};

Bytes exr_of(const ExrLayer& layer) {
  const TempFolder folder;
  const std::string path = folder.str() + "/a.exr";
  write_exr(path, {layer});
  std::ifstream in(path, std::ios::binary);
  return Bytes{std::istreambuf_iterator<char>(in), {}};
}

Image image_of(const std::vector<double>& values, int wide = kWide, int high = kHigh) {
  Image out(wide, high, 1);
  for (std::size_t i = 0; i < values.size(); ++i) out.data[i] = float(values[i]);
  return out;
}

TEST_SUITE("data/depth") {
  TEST_CASE("PNG in millimetres, OpenEXR by any usual channel and numpy's tables say the same") {
    const std::vector<double> z = metres();
    std::vector<std::pair<std::string, Bytes>> files{{".png", depth_png()},
                                                     {".npy", npy_bytes(kHigh, kWide, z)},
                                                     {".npy", npy_bytes(kHigh, kWide, z, "<f4")}};
    for (const auto& [name, letter] : {std::pair{"", "Z"}, {"", "Y"}, {"depth", ""}, {"View.Depth", "Z"}})
      files.emplace_back(".exr", exr_of({name, image_of(z), {letter}}));
    for (const auto& [name, bytes] : files) {
      CAPTURE(name);
      const Dataset data = Deep(name, bytes).load("metric");
      const DepthMap& depth = first_frame(data).depth;
      REQUIRE_FALSE(depth.empty());
      CHECK(depth.kind() == DepthKind::metric);
      for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x)
          CHECK(depth.at(x, y, kWide, kHigh) == doctest::Approx(1e-3 * depth_of(x, y)).epsilon(5e-4));
      CHECK(depth.at(0, 0, kWide, kHigh) == 0);
      CHECK(depth.known_share() == doctest::Approx(1 - 1.0 / (kWide * kHigh)));
      REQUIRE(data.depth);
      CHECK(data.depth->pictures == data.depth->frames);
      CHECK(data.depth->known == doctest::Approx(depth.known_share()));
    }
  }

  TEST_CASE("maps named by another machine's paths are found as its pictures are") {
    using Words = std::pair<std::string, std::string>;
    for (const auto& [before, slash] : {Words{"C:\\\\data\\\\scene\\\\", "\\\\"}, {"/home/me/scene/", "/"}}) {
      CAPTURE(before);
      const Deep deep(".png", depth_png());
      for (const std::string place : {"images", "depth"})
        replace_in(deep.folder.path() / "transforms.json", "\"" + place + "/", "\"" + before + place + slash);
      const Dataset data = deep.load("metric");
      CHECK(notes_with(data, "paths of another machine").size() == 1);
      CHECK(notes_with(data, "are not there").empty());
      REQUIRE(data.depth);
      CHECK(data.depth->pictures == data.depth->frames);
      CHECK_FALSE(first_frame(data).depth.empty());
    }
  }

  TEST_CASE("a unit of the file makes depth metric, without one it is relative; a rule decides otherwise") {
    const std::string unit = "\"depth_unit_scale_factor\": 0.01, ";
    const Dataset metric = Deep(".png", depth_png(), unit).load(), plain = Deep(".png", depth_png()).load(),
                  inverse = Deep(".png", depth_png(), unit).load("inverse");
    CHECK(first_frame(metric).depth.kind() == DepthKind::metric);
    CHECK(first_frame(metric).depth.at(3, 2, kWide, kHigh) == doctest::Approx(13.2).epsilon(5e-4));
    CHECK(first_frame(plain).depth.kind() == DepthKind::relative);
    CHECK(first_frame(inverse).depth.kind() == DepthKind::inverse);
    CHECK(metric.depth->kind == "metric");
    CHECK(plain.notes.back().find("no depth_unit_scale_factor gives a unit") != std::string::npos);
    CHECK(metric.fingerprint != plain.fingerprint);
    CHECK(metric.fingerprint != inverse.fingerprint);
  }

  TEST_CASE("what is not finite is unknown, and relative numbers may be below 0") {
    std::vector<double> z = metres();
    z[5] = std::numeric_limits<double>::quiet_NaN();
    z[6] = std::numeric_limits<double>::infinity();
    z[7] = -2;
    const Deep deep(".npy", npy_bytes(kHigh, kWide, z));
    z[8] = 1e10;  // as renderers write where nothing is
    const Deep far(".npy", npy_bytes(kHigh, kWide, z));
    const DepthMap depth = first_frame(deep.load("relative")).depth,
                   beside = first_frame(far.load("relative")).depth;
    CHECK(beside.value(8) == 0);
    for (const std::size_t i : {0, 4, 7, 9}) CHECK(beside.value(i) == depth.value(i));
    CHECK(depth.value(5) == 0);
    CHECK(depth.value(6) == 0);
    CHECK(depth.value(7) == doctest::Approx(-2));
    expect_error([&] { deep.load("metric"); }, {"depth/0.npy", "depths below 0", "-2", "--depth relative"});
  }

  TEST_CASE("smaller and larger maps of the picture's shape are taken, pixel by nearest pixel") {
    const Deep half(".npy", npy_bytes(kHigh / 2, kWide / 2, metres(kWide / 2, kHigh / 2)));
    const DepthMap small = first_frame(half.load("metric")).depth;
    CHECK(small.width() == kWide / 2);
    CHECK(small.at(7, 5, kWide, kHigh) == doctest::Approx(1e-3 * depth_of(3, 2)).epsilon(5e-4));
    const DepthMap reduced = first_frame(Deep(".png", depth_png()).load("metric", 2)).depth;
    CHECK(reduced.width() == kWide / 2);
    CHECK(reduced.at(3, 2, kWide / 2, kHigh / 2) == doctest::Approx(1e-3 * depth_of(7, 5)).epsilon(5e-4));
  }

  TEST_CASE("nothing is read where nobody asks, and nothing changes then") {
    const Deep deep(".png", depth_png());
    const Dataset asked = deep.load("none"), plain = deep.load("", 1, false);
    CHECK(first_frame(plain).depth.empty());
    CHECK_FALSE(plain.depth);
    CHECK(first_frame(asked).depth.empty());
    CHECK(asked.depth->kind == "none");
    CHECK(asked.fingerprint == plain.fingerprint);
    const Dataset absent = Deep(".png", {}).load();
    CHECK(absent.fingerprint == plain.fingerprint);
    CHECK(absent.notes.back().find("are not there, first 'depth/0.png'") != std::string::npos);
  }

  TEST_CASE("files that are no depth are refused by name, with what to try") {
    const std::string without = "--depth none";
    const auto refused = [&](const std::string& name, const Bytes& bytes, std::vector<std::string> parts) {
      CAPTURE(name);
      parts.insert(parts.end(), {"depth/0" + name, "frame_0000.png"});
      const Deep deep(name, bytes);
      expect_error([&] { deep.load(); }, parts);
    };
    refused(".png", png_bytes(flat_png(kWide, kHigh)), {"16 bits", without});
    refused(".png", depth_png(kHigh, kHigh), {"another shape", "12 x 8", "8 x 8", without});
    refused(".npy", npy_bytes(1, kWide, metres(kWide, 1)), {"two axes", without});
    refused(".exr", exr_of({"normal", Image(kWide, kHigh, 3), {"X", "Y", "Z"}}),
            {"no channel of depth", without});
    refused(".txt", Bytes{'1', '2'}, {"a kind that is not read", without});
    const Bytes png = depth_png();
    refused(".png", Bytes(png.begin(), png.end() - 40), {"truncated or damaged"});
    expect_error([] { Deep(".png", depth_png()).load("far"); },
                 {"--depth", "metric, relative, inverse or none"});
    expect_error([] { Deep(".png", depth_png(), "\"depth_unit_scale_factor\": 0, ").load(); },
                 {"depth_unit_scale_factor", "above 0"});
  }

  TEST_CASE("a built-in scene writes the depth that it has in memory") {
    for (const DepthKind kind : {DepthKind::metric, DepthKind::relative, DepthKind::inverse}) {
      const TempFolder folder;
      const SynthOptions options{.frames = 4, .size = 16, .depth = kind};
      write_synth("toy", folder.str(), options);
      LoadOptions load;
      load.depth = true;
      load.rules.depth = kind == DepthKind::inverse ? "inverse" : "";  // the others are told apart
      const Dataset data = load_dataset(folder.str(), load), made = make_synth("toy", options);
      const std::vector<Frame>&read = data.find("train")->frames, &kept = made.find("train")->frames;
      for (std::size_t f = 0; f < read.size(); ++f) {
        CHECK(read[f].depth.kind() == kind);
        CHECK(read[f].depth.known_share() > 0.1);
        for (int i = 0; i < 16 * 16; ++i)
          CHECK(read[f].depth.value(std::size_t(i)) == kept[f].depth.value(std::size_t(i)));
      }
      CHECK(made.find("test")->frames[0].depth.empty());
    }
    expect_error([] { make_synth("smoke", {.frames = 2, .size = 8, .depth = DepthKind::metric}); },
                 {"--depth", "gas"});
  }
}

}  // namespace
