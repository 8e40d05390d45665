// SPDX-License-Identifier: Apache-2.0
#include "run/correspondence.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "data/pictures/exr.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "support/blob_model.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

namespace {

/// Points on a sphere that moves by `travel` per unit of time, or rests.
std::vector<SurfaceFrame> sphere(const std::vector<double>& times, const Vec3& travel) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<Vec3> rest(2000);
  for (Vec3& r : rest) r = 0.3f * normalize(Vec3{normal(random), normal(random), normal(random)});
  std::vector<SurfaceFrame> frames;
  for (const double t : times) {
    frames.push_back({t, {}, rest});
    for (const Vec3& r : rest) frames.back().position.push_back(r + float(t) * travel);
  }
  return frames;
}

}  // namespace

TEST_SUITE("app/correspondence") {
  const Vec3 travel{0.5f, -0.1f, -0.2f};
  BlobMotion moves() {
    BlobMotion motion;
    motion.shift = -travel;
    return motion;
  }
  TEST_CASE("the true motion has no error, and none of it is missed") {
    const MotionScore s = score_motion(blob_model(32, moves()), sphere({0, 0.3, 1}, travel), 500);
    CHECK(s.edge == doctest::Approx(2.1));
    CHECK(s.canonical.count == 3 * 2 * 500);
    CHECK(s.canonical.p90 < 1e-5);
    CHECK(s.tracked.p90 < 1e-4);
    CHECK(s.tracked_far.count == 2 * 2 * 500);  // 0 and 0.3 are too near
    CHECK(s.tracked_far.p90 < 1e-4);
    CHECK(s.folded == 0);
    CHECK(s.still_pairs == 0);
    CHECK(std::isnan(s.still_moved));  // of no pairs there is no share
    CHECK(s.moving_pairs == s.canonical.count);
    CHECK(s.moving_missed == 0);
  }
  TEST_CASE("no motion where there should be: the error is the distance travelled, and all of it is missed") {
    BlobMotion none;
    none.moves = false;
    const MotionScore s = score_motion(blob_model(32, none), sphere({0, 1}, travel));
    CHECK(s.canonical.median == doctest::Approx(length(travel)));
    CHECK(s.tracked.median == doctest::Approx(length(travel)));
    CHECK(s.moving_missed == 1);
  }
  TEST_CASE("motion where there should be none is counted") {
    const MotionScore s = score_motion(blob_model(32, moves()), sphere({0, 1}, {}));
    CHECK(s.still_pairs == s.canonical.count);
    CHECK(s.still_moved == 1);
    CHECK(s.moving_pairs == 0);
    CHECK(std::isnan(s.moving_missed));
    CHECK(s.tracked_far.count > 0);
    const MotionScore near = score_motion(blob_model(32, moves()), sphere({0, 0.3}, {}));
    CHECK(near.tracked_far.count == 0);
    CHECK(std::isnan(near.tracked_far.median));
  }
  TEST_CASE("surface points are read at pixels away from edges; an absent or wrong file is named") {
    const TempFolder folder;
    std::filesystem::create_directories(folder.path() / "truth");
    const Camera camera{8, 8, 100, 100, 4, 4, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}, {}};
    Image position(8, 8, 3), rest(8, 8, 4);
    for (int y = 2; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3d seen = (x >= 5 ? 2.0 : 1.0) * camera_ray(camera, x + 0.5, y + 0.5).direction;
        for (int c = 0; c < 3; ++c) {
          position.pixel(x, y)[c] = float(seen[c]);
          rest.pixel(x, y)[c] = 2;
        }
      }
    const std::string path = (folder.path() / "truth/r_7_0000.exr").string();
    write_exr(path, {{"position", position, {"X", "Y", "Z"}}, {"rest", rest, {"R", "G", "B", "A"}}});
    Split split{"test", {}};
    split.frames.push_back({"r_7", camera, 0.25, {}, -1});
    const auto frames = read_truth(folder.str(), split, 0.1f);
    REQUIRE(frames.size() == 1);
    CHECK(frames[0].time == 0.25);
    // Rows 3..6 (2 is the edge of what is hit, 7 of the picture), columns 1..3 and 6: 4 and 5 lie at the
    // step.
    CHECK(frames[0].position.size() == 4 * 4);
    CHECK(frames[0].rest.size() == 4 * 4);
    Split half = split;  // pictures may be read smaller than the truth is
    half.frames[0].camera = {4, 4, 50, 50, 2, 2, camera.axes, {}, {}};
    CHECK(read_truth(folder.str(), half, 0.1f)[0].position.size() == 4 * 4);
    Split other = split;
    other.frames[0].camera.position = {0.1, 0, 0};
    CHECK_THROWS_WITH_AS(read_truth(folder.str(), other, 0.1f),
                         doctest::Contains("belongs to another view than 'r_7'"), Error);
    other.frames[0].camera.position = {0, 0, -9};
    CHECK_THROWS_WITH_AS(read_truth(folder.str(), other, 0.1f), doctest::Contains("points behind the camera"),
                         Error);
    write_exr(path, {{"position", position, {"X", "Y", "Z"}}});
    CHECK_THROWS_WITH_AS(read_truth(folder.str(), split, 0.1f), doctest::Contains("there is no layer 'rest'"),
                         Error);
    split.frames[0].name = "r_8";
    CHECK_THROWS_WITH_AS(read_truth(folder.str(), split, 0.1f), doctest::Contains("no motion ground truth"),
                         Error);
  }
}
