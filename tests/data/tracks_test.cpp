// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "data/expect_error.hpp"
#include "data/layouts.hpp"
#include "data/wild.hpp"
#include "splinevox/data/synth.hpp"
#include "support/numpy_file.hpp"

/// Files of points that are followed through pictures: how they are read, what is refused.
namespace {

using namespace splinevox;
using namespace splinevox::test;

constexpr int kCount = 9, kPoints = 5;

float place_of(int point, int picture, int axis) {
  return float(axis == 0 ? 1 + point + 0.5 * picture : 2 + 0.25 * point + 0.5 * picture);
}

/// Places of points through pictures, one axis before the other.
std::vector<float> places(int pictures, bool points_first) {
  std::vector<float> out;
  const int outer = points_first ? kPoints : pictures, inner = points_first ? pictures : kPoints;
  for (int a = 0; a < outer; ++a)
    for (int b = 0; b < inner; ++b)
      for (int axis = 0; axis < 2; ++axis)
        out.push_back(place_of(points_first ? a : b, points_first ? b : a, axis));
  return out;
}

std::string npy_of(const std::vector<float>& values, const std::string& shape) {
  return numpy("<f4", shape, bytes_of(values));
}

/// nerfstudio's layout, one list of nine pictures of which the fifth is held out, and a file of tracks.
struct Followed {
  TempFolder folder;
  explicit Followed(const std::string& name, const std::string& bytes, const std::string& field = "") {
    write_nerfstudio_with(folder.path(), film_cameras(kCount),
                          field.empty() ? "" : "\"tracks_file_path\": " + field + ", ");
    write_text(folder.path() / name, bytes);
  }
  Dataset load(const std::string& file = "", int downscale = 1, bool tracks = true) const {
    LoadOptions options;
    options.downscale = downscale;
    options.tracks = tracks;
    options.rules.tracks = file.empty() || file == "none" ? file : (folder.path() / file).string();
    return load_dataset(folder.str(), options);
  }
};

void check_places(const Dataset& data, int downscale = 1) {
  const Split& train = *data.find("train");
  REQUIRE(int(train.frames.size()) < kCount);
  for (const Frame& f : train.frames) {
    const int picture = int(std::lround(f.time * (kCount - 1)));
    CAPTURE(picture);
    REQUIRE(f.tracks.size() == kPoints);
    for (const VisiblePoint& p : f.tracks) {
      CHECK(p.u == doctest::Approx(place_of(p.point, picture, 0) / downscale));
      CHECK(p.v == doctest::Approx(place_of(p.point, picture, 1) / downscale));
    }
  }
}

TEST_SUITE("data/tracks") {
  TEST_CASE("tables of both orders, with and without a batch, in .npy and .npz say the same") {
    const std::string by_points = npy_of(places(kCount, true), "(5, 9, 2)"),
                      by_pictures = npy_of(places(kCount, false), "(1, 9, 5, 2)");
    check_places(Followed("a.npy", by_points).load("a.npy"));
    check_places(Followed("a.npy", by_pictures).load("a.npy"));
    check_places(Followed("a.npz", npz({{"tracks.npy", by_points}}, true)).load("a.npz"));
    const std::string zeros =
        numpy("<f4", "(1000000,)", std::string(4000000, '\0'));  // packed as well as can be
    check_places(
        Followed("a.npz", npz({{"tracks.npy", by_points}, {"zeros.npy", zeros}}, true)).load("a.npz"));
    const Dataset named =
        Followed("a.npz", npz({{"pred_tracks.npy", by_pictures}}, false), "\"a.npz\"").load();
    check_places(named);
    REQUIRE(named.tracks);
    CHECK(named.tracks->points == kPoints);
    CHECK(named.tracks->pictures == kCount);
    CHECK(named.tracks->visible == 1);
    CHECK(named.notes.back().find("tracks of 5 points through 9 pictures") != std::string::npos);
    check_places(Followed("a.npy", by_points).load("a.npy", 2), 2);
  }

  TEST_CASE("a file named by another machine's path is found as its pictures are") {
    const std::string before = "\"C:\\\\data\\\\scene\\\\";
    const Followed followed("a.npy", npy_of(places(kCount, true), "(5, 9, 2)"), before + "a.npy\"");
    replace_in(followed.folder.path() / "transforms.json", "\"images/", before + "images\\\\");
    check_places(followed.load());
  }

  TEST_CASE("a file of the pictures that train alone is as good, in their order") {
    const Dataset all = Followed("a.npy", npy_of(places(kCount, true), "(5, 9, 2)")).load("a.npy");
    const std::size_t n = all.find("train")->frames.size();
    const std::string shape = "(5, " + std::to_string(n) + ", 2)";
    const Dataset data = Followed("a.npy", npy_of(places(int(n), true), shape)).load("a.npy");
    for (std::size_t f = 0; f < n; ++f)
      CHECK(data.find("train")->frames[f].tracks[3].u == place_of(3, int(f), 0));
  }

  TEST_CASE("what is hidden, not finite or outside of its picture is not seen") {
    std::vector<float> values = places(kCount, true);
    values[0] = std::numeric_limits<float>::quiet_NaN();  // point 0, picture 0
    values[std::size_t(2 * (kCount + 1))] = 1000;         // point 1, picture 1
    std::string hidden(kPoints * kCount, '\0'), seen(kPoints * kCount, '\1');
    hidden[2 * kCount + 2] = '\1';  // point 2, picture 2
    seen[2 * kCount + 2] = '\0';
    for (const auto& [name, flags] : {std::pair{"occluded", hidden}, {"visible", seen}}) {
      const std::string file = npz({{"tracks.npy", npy_of(values, "(5, 9, 2)")},
                                    {std::string(name) + ".npy", numpy("|b1", "(5, 9)", flags)},
                                    {"names.npy", numpy("<U1", "(1,)", "a   ")}},  // of no concern
                                   false);
      const Dataset data = Followed("a.npz", file).load("a.npz");
      std::size_t seen_count = 0;
      for (const Frame& f : data.find("train")->frames) {
        seen_count += f.tracks.size();
        const int picture = int(std::lround(f.time * (kCount - 1)));
        for (const VisiblePoint& p : f.tracks) CHECK_FALSE((p.point == picture && picture < 3));
      }
      CHECK(seen_count == data.find("train")->frames.size() * kPoints - 3);
      CHECK(data.tracks->visible < 1);
    }
  }

  TEST_CASE("nothing is read where nobody asks, and nothing changes then") {
    const Followed set("a.npy", npy_of(places(kCount, true), "(5, 9, 2)"), "\"a.npy\"");
    const Dataset plain = set.load("", 1, false), none = set.load("none"), used = set.load();
    CHECK_FALSE(plain.tracks);
    CHECK_FALSE(none.tracks);
    CHECK(plain.find("train")->frames[0].tracks.empty());
    CHECK(plain.fingerprint == none.fingerprint);
    CHECK(plain.fingerprint != used.fingerprint);
  }

  TEST_CASE("files that are no tracks of these pictures are refused by name, with what to try") {
    const auto refused = [](const std::string& name, const std::string& bytes,
                            std::vector<std::string> parts) {
      CAPTURE(name);
      parts.push_back(name);
      const Followed set(name, bytes);
      expect_error([&] { set.load(name); }, parts);
    };
    const std::string without = "--tracks none";
    refused("a.npy", npy_of(places(kCount + 1, true), "(5, 10, 2)"),
            {"other pictures", "all 9", "(5, 10, 2)", without});
    refused("a.npy", npy_of(std::vector<float>(9 * 9 * 2), "(9, 9, 2)"), {"which axis", "(9, 9, 2)"});
    refused("a.npy", npy_of(std::vector<float>(5 * 9 * 3), "(5, 9, 3)"),
            {"another shape", "(points, pictures, 2)"});
    refused("a.npy", npy_of(std::vector<float>(5 * 9 * 2, 500.0f), "(5, 9, 2)"), {"outside", "12 x 8"});
    refused("a.npy", npy_of(std::vector<float>(5 * 9 * 2, std::nanf("")), "(5, 9, 2)"), {"no point is seen"});
    refused("a.npz", npz({{"flow.npy", npy_of(places(kCount, true), "(5, 9, 2)")}}, false),
            {"no array of tracks", "flow"});
    refused("a.npz",
            npz({{"tracks.npy", npy_of(places(kCount, true), "(5, 9, 2)")},
                 {"visible.npy", numpy("|b1", "(9, 5)", std::string(45, '\1'))}},
                false),
            {"what is visible is of another shape", "(5, 9)", "(9, 5)"});
    // Half a gigabyte is said to be in some hundred bytes. The directory is one entry; its size is four
    // numbers from its end.
    const std::size_t end = 22, name = std::string("tracks.npy").size(), size = name + 22;
    std::string swollen = npz({{"tracks.npy", npy_of(places(kCount, true), "(5, 9, 2)")}}, true);
    swollen.replace(swollen.size() - end - size, 4, std::string("\0\0\0\x20", 4));
    refused("a.npz", swollen, {"this .npz file is damaged", "larger than it can be"});
    refused("a.txt", "1 2 3", {"not read", ".npy or .npz"});
    const Followed set("a.npy", "", "\"b.npy\"");
    expect_error([&] { set.load(); }, {"tracks_file_path", "b.npy"});
    expect_error([&] { set.load("c.npy"); }, {"--tracks", "c.npy"});
    const TempFolder rig;
    SynthOptions options{.frames = 3, .size = 16};
    options.rig.cameras = 2;
    write_synth("toy", rig.str(), options);
    write_text(rig.path() / "a.npy", npy_of(places(6, true), "(5, 6, 2)"));
    LoadOptions load;
    load.tracks = true;
    load.rules.tracks = rig.str() + "/a.npy";
    expect_error([&] { load_dataset(rig.str(), load); }, {"one moment", "one camera"});
  }

  TEST_CASE("a built-in scene writes the tracks that it has in memory") {
    const TempFolder folder;
    SynthOptions options{.frames = 6, .size = 32, .orbit = 0.3, .film = true};
    options.tracks = true;
    write_synth("toy", folder.str(), options);
    LoadOptions load;
    load.tracks = true;
    const Dataset data = load_dataset(folder.str(), load), made = make_synth("toy", options);
    const std::vector<Frame>&read = data.find("train")->frames, &kept = made.find("train")->frames;
    for (std::size_t f = 0; f < read.size(); ++f) {
      REQUIRE(read[f].tracks.size() == kept[f].tracks.size());
      CHECK(read[f].tracks.size() > 50);
      for (std::size_t i = 0; i < read[f].tracks.size(); ++i) {
        CHECK(read[f].tracks[i].point == kept[f].tracks[i].point);
        CHECK(read[f].tracks[i].u == kept[f].tracks[i].u);
        CHECK(read[f].tracks[i].v == kept[f].tracks[i].v);
      }
    }
    CHECK(made.find("test")->frames[0].tracks.empty());
    SynthOptions gas{.frames = 2, .size = 8}, rig = gas;
    gas.tracks = rig.tracks = true;
    rig.rig.cameras = 2;
    expect_error([&] { make_synth("smoke", gas); }, {"--tracks", "gas"});
    expect_error([&] { make_synth("toy", rig); }, {"--tracks", "one camera"});
  }
}

}  // namespace
