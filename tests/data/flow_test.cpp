// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "data/expect_error.hpp"
#include "data/layouts.hpp"
#include "data/pictures/exr.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "support/numpy_file.hpp"

/// Optical flow between pictures, from which points are followed: how it is read, where points are lost.
namespace {

using namespace splinevox;
using namespace splinevox::test;

constexpr int kPictures = 9;
constexpr float kRight = 0.25f, kDown = -0.125f;

/// [height * width * 2], the same everywhere.
std::vector<float> everywhere(float u, float v, int width = kWide, int height = kHigh) {
  std::vector<float> out;
  for (int i = 0; i < width * height; ++i) out.insert(out.end(), {u, v});
  return out;
}

std::string flo(const std::vector<float>& values, int width = kWide, int height = kHigh) {
  const std::vector<std::int32_t> sides = {width, height};
  return "PIEH" + bytes_of(sides) + bytes_of(values);
}

Image image_of(const std::vector<float>& values) {
  Image image(kWide, kHigh, 2);
  image.data = values;
  return image;
}

std::vector<float> planes(const std::vector<float>& pairs) {
  std::vector<float> out;
  for (std::size_t a = 0; a < 2; ++a)
    for (std::size_t i = a; i < pairs.size(); i += 2) out.push_back(pairs[i]);
  return out;
}

/// A film of nine pictures of which one is held out, and a folder of flow.
struct Flowing {
  TempFolder folder;
  explicit Flowing(const std::string& field = "") {
    write_nerfstudio_with(folder.path(), film_cameras(kPictures), field);
    std::filesystem::create_directory(flow());
  }
  std::filesystem::path flow() const { return folder.path() / "flow"; }
  /// @param name  "k" stands for the number of the file
  Flowing& put(const std::string& name, const std::string& bytes, int files = kPictures - 1) {
    for (int k = 0; k < files; ++k) put_one(k, name, bytes);
    return *this;
  }
  Flowing& put_one(int k, std::string name, const std::string& bytes) {
    name.replace(name.find('k'), 1, std::to_string(k));
    write_text(flow() / name, bytes);
    return *this;
  }
  Dataset load(int downscale = 1) const {
    LoadOptions options;
    options.downscale = downscale;
    options.tracks = true;
    options.rules.tracks = flow().string();
    return load_dataset(folder.str(), options);
  }
};

int picture_of(const Frame& frame) { return int(std::lround(frame.time * (kPictures - 1))); }

/// Where each point is, by picture.
std::map<int, std::map<int, VisiblePoint>> ways(const Dataset& data) {
  std::map<int, std::map<int, VisiblePoint>> out;
  for (const Frame& f : data.find("train")->frames)
    for (const VisiblePoint& p : f.tracks) out[p.point][picture_of(f)] = p;
  return out;
}

void check_ways(const Dataset& data, float scale = 1) {
  std::size_t steps = 0;
  for (const auto& [point, seen] : ways(data))
    for (const auto& [picture, at] : seen) {
      const auto& [first, from] = *seen.begin();
      CHECK(at.u == doctest::Approx(from.u + scale * kRight * float(picture - first)));
      CHECK(at.v == doctest::Approx(from.v + scale * kDown * float(picture - first)));
      steps += picture > first;
    }
  CHECK(steps > 1000);
}

TEST_SUITE("data/flow") {
  TEST_CASE("flow of every kind of file leads points the same way, through pictures held out too") {
    const std::vector<float> values = everywhere(kRight, kDown);
    check_ways(Flowing().put("k.flo", flo(values)).load());
    check_ways(Flowing().put("k.flo", flo(values)).put("._k.flo", "of macOS").load());
    check_ways(Flowing().put("k.npy", numpy("<f4", "(8, 12, 2)", bytes_of(values))).load());
    check_ways(Flowing().put("k.npy", numpy("<f4", "(1, 2, 8, 12)", bytes_of(planes(values)))).load());
    const std::string table = numpy("<f4", "(8, 12, 2)", bytes_of(values));
    const std::string mask = numpy("<f4", "(8, 12)", bytes_of(std::vector<float>(96, 1.0f)));
    check_ways(Flowing().put("k_fwd.npz", npz({{"flow.npy", table}, {"mask.npy", mask}}, true)).load());
    const Flowing exr;
    const Image image = image_of(values);
    for (int k = 0; k + 1 < kPictures; ++k)
      write_exr((exr.flow() / (std::to_string(k) + ".exr")).string(), {{"", image, {"u", "v"}}});
    check_ways(exr.load());
    const Dataset data = Flowing().put("k.flo", flo(values)).load();
    CHECK(data.find("train")->frames.size() < std::size_t(kPictures));
    CHECK(data.tracks->pictures == kPictures);
    CHECK(data.tracks->points == ways(data).rbegin()->first + 1u);
  }

  TEST_CASE("of a file with flow both ways the layer of that way is taken") {
    const Flowing set, unclear;
    const Image there = image_of(everywhere(kRight, kDown)), back = image_of(everywhere(-kRight, -kDown));
    for (int k = 0; k + 1 < kPictures; ++k) {
      for (const char* name : {"_fwd.exr", "_bwd.exr"})
        write_exr((set.flow() / (std::to_string(k) + name)).string(),
                  {{"backward", back, {"u", "v"}}, {"forward", there, {"u", "v"}}});
      write_exr((unclear.flow() / (std::to_string(k) + ".exr")).string(),
                {{"a", back, {"u", "v"}}, {"b", there, {"u", "v"}}});
    }
    check_ways(set.load());
    expect_error([&] { unclear.load(); }, {"which layer", "forward", "a. b."});
  }

  TEST_CASE("files are taken in the order in which people count, each for its own picture") {
    Flowing set;  // 2 ... 10: as text "10" would come first
    for (int k = 0; k + 1 < kPictures; ++k) set.put_one(k + 2, "k.flo", flo(everywhere(0.1f * float(k), 0)));
    const Dataset data = set.load();
    std::size_t steps = 0;
    for (const auto& [point, seen] : ways(data))
      for (const auto& [picture, at] : seen) {
        const int first = seen.begin()->first;
        const float expected = 0.05f * float(picture * (picture - 1) - first * (first - 1));
        CHECK(at.u - seen.begin()->second.u == doctest::Approx(expected).epsilon(1e-3));
        steps += picture > first;
      }
    CHECK(steps > 1000);
  }

  TEST_CASE("flow of smaller pictures of the same shape is stretched, and shrunk with the pictures") {
    const std::string half = flo(everywhere(kRight, kDown, kWide / 2, kHigh / 2), kWide / 2, kHigh / 2);
    check_ways(Flowing().put("k.flo", half).load(), 2);
    check_ways(Flowing().put("k.flo", half).load(2), 1);
  }

  TEST_CASE("a folder that the data names is read, and only there") {
    Flowing named("\"tracks_file_path\": \"flow\", ");
    named.put("k.flo", flo(everywhere(kRight, kDown)));
    LoadOptions options;
    options.tracks = true;
    check_ways(load_dataset(named.folder.str(), options));
    options.rules.tracks = "none";
    CHECK_FALSE(load_dataset(named.folder.str(), options).tracks);
    const Flowing outside("\"tracks_file_path\": \"..\", ");
    options.rules.tracks.clear();
    expect_error([&] { load_dataset(outside.folder.str(), options); }, {"tracks_file_path", "'..'"});
  }

  TEST_CASE("no square of a picture is without a point, nor full of them, however flow gathers them") {
    std::vector<float> values = everywhere(0, 0);  // to the left edge, faster the further away
    for (int i = 0; i < kWide * kHigh; ++i) values[std::size_t(2 * i)] = -0.5f * float(i % kWide);
    const Dataset data = Flowing().put("k.flo", flo(values)).load();
    for (const Frame& f : data.find("train")->frames)
      if (picture_of(f) + 1 < kPictures) {  // the last begins none
        std::map<std::pair<int, int>, int> squares;
        for (const VisiblePoint& p : f.tracks) ++squares[{int(4 * p.u), int(4 * p.v)}];
        CHECK(squares.size() == 48 * 32);
        for (const auto& [square, points] : squares) CHECK(points <= 16);
      }
  }

  TEST_CASE("a point is lost where flow is unknown, leads outside, or does not lead back") {
    constexpr int kPicture = 4;  // from which flow is another
    const auto lost = [&](const std::vector<float>& there, const std::vector<float>& back) {
      Flowing set;
      set.put("k_fwd.flo", flo(everywhere(0, 0))).put_one(kPicture, "k_fwd.flo", flo(there));
      set.put("k_bwd.flo", flo(everywhere(0, 0))).put_one(kPicture, "k_bwd.flo", flo(back));
      std::size_t left = 0, right = 0;  // points that end in this picture, by half
      for (const auto& [point, seen] : ways(set.load()))
        if (seen.rbegin()->first <= kPicture) ++(seen.rbegin()->second.u < kWide / 2 ? left : right);
      return std::pair{left, right};
    };
    const std::vector<float> none = everywhere(0, 0);
    CHECK(lost(none, none) == std::pair<std::size_t, std::size_t>{0, 0});
    const auto in_right_half = [&](float u) {
      std::vector<float> out = none;
      for (int i = 0; i < kWide * kHigh; ++i)
        if (i % kWide >= kWide / 2) out[std::size_t(2 * i)] = u;
      return out;
    };
    for (const auto& [there, back] : {std::pair{in_right_half(2e9f), none},
                                      {in_right_half(std::numeric_limits<float>::quiet_NaN()), none},
                                      {in_right_half(float(kWide)), none},
                                      {none, in_right_half(3)}}) {
      const auto [left, right] = lost(there, back);
      CHECK(left <= 2 * 32);  // at most two columns beside the border, where pixels are mixed
      CHECK(right >= 22 * 32);
    }
  }

  TEST_CASE("without flow backward a note says what is not known") {
    const auto warned = [](const Dataset& data) {
      for (const std::string& note : data.notes)
        if (note.find("flow leads forward alone") != std::string::npos) return true;
      return false;
    };
    const std::string forward = flo(everywhere(kRight, kDown)), backward = flo(everywhere(-kRight, -kDown));
    CHECK(warned(Flowing().put("k.flo", forward).load()));
    const Dataset both = Flowing().put("k_fwd.flo", forward).put("k_bwd.flo", backward).load();
    CHECK_FALSE(warned(both));
    check_ways(both);
  }

  TEST_CASE("flow of one pair that is missing is not taken for flow of the pictures that train") {
    const std::string values = flo(everywhere(kRight, kDown));
    std::vector<int> train;
    for (const Frame& f : Flowing().put("k.flo", values).load().find("train")->frames)
      train.push_back(picture_of(f));
    REQUIRE(train.size() == std::size_t(kPictures) - 1);
    std::sort(train.begin(), train.end());
    Flowing of_train;  // a file for each picture that trains and the next, named as its picture
    for (std::size_t k = 0; k + 1 < train.size(); ++k)
      of_train.put_one(train[k], "frame_k_640x480.flo", values);
    CHECK(of_train.load().tracks->pictures == kPictures - 1);
    Flowing moments;  // in milliseconds
    for (std::size_t k = 0; k + 1 < train.size(); ++k) moments.put_one(train[k] * 100 / 3, "k.flo", values);
    CHECK(moments.load().tracks->pictures == kPictures - 1);
    CHECK(Flowing().put("k.flo", values, kPictures - 2).load().tracks->pictures == kPictures - 1);
    for (const int lost : {2, 6}) {
      Flowing set;
      set.put("0k.flo", values);
      std::filesystem::remove(set.flow() / ("0" + std::to_string(lost) + ".flo"));
      expect_error([&] { set.load(); },
                   {"flow is missing between two of its files", "0" + std::to_string(lost - 1) + ".flo",
                    "0" + std::to_string(lost + 1) + ".flo", "--tracks none"});
    }
  }

  TEST_CASE("what is no flow of these pictures is refused by name, with what to try") {
    const std::string good = flo(everywhere(0, 0)), without = "--tracks none";
    const auto refused = [&](const Flowing& set, std::vector<std::string> parts) {
      parts.push_back(without);
      expect_error([&] { set.load(); }, parts);
    };
    refused(Flowing(), {"no flow in this folder", ".flo"});
    refused(Flowing().put("k.flo", good, 5), {"other pictures", "7 or 8 files", "5"});
    refused(Flowing().put("k.flo", good).put("k_bwd.flo", good, 3), {"not as much flow backward", "8", "3"});
    refused(Flowing().put("k.flo", flo(everywhere(0, 0, 12, 12), 12, 12)),
            {"another shape", "12 x 8", "12 x 12"});
    refused(Flowing().put("k.flo", good).put_one(3, "k.flo", flo(everywhere(0, 0, 6, 4), 6, 4)),
            {"not all of one size", "12 x 8", "6 x 4"});
    refused(Flowing().put("k.flo", good.substr(0, 100)), {"0.flo", "not whole", "100 bytes"});
    refused(Flowing().put("k.flo", "PIEH"), {"0.flo", "not whole", "4 bytes"});
    refused(Flowing().put("k.flo", "{}"), {"0.flo", "not read", ".npy"});
    refused(Flowing().put("k.npy", numpy("<f4", "(8, 12)", bytes_of(std::vector<float>(96)))),
            {"0.npy", "another shape", "(height, width, 2)", "(8, 12)"});
    refused(Flowing().put("k.exr", "\x76\x2f\x31\x01"), {"0.exr"});
    const Flowing exr;
    write_exr((exr.flow() / "0.exr").string(), {{"depth", Image(kWide, kHigh, 1), {}}});
    for (int k = 1; k + 1 < kPictures; ++k)
      std::filesystem::copy(exr.flow() / "0.exr", exr.flow() / (std::to_string(k) + ".exr"));
    refused(exr, {"0.exr", "no channels of flow", "depth"});
  }
}

}  // namespace
