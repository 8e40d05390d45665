// SPDX-License-Identifier: Apache-2.0
#include "run/held_camera.hpp"

#include <doctest/doctest.h>

#include "math/camera.hpp"
#include "run/still_places.hpp"
#include "splinevox/data/synth.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

namespace {

/// A camera in a hand that goes a short arc about a scene before a wall.
Dataset film(const char* scene) {
  return make_synth(
      scene, {.frames = 40, .size = 96, .orbit = 0.1, .film = true, .shake = 0.02, .look = {.opaque = true}});
}

const Dataset& still_film() {
  static const Dataset data = film("static");
  return data;
}

/// A block in the middle that drifts by `shift` between time 0 and 1, or rests.
VoxelModel block(const Vec3& shift, bool moves = true) {
  BlobMotion motion;
  motion.moves = moves;
  motion.shift = shift;
  VoxelModel model = blob_model(32, motion);
  const std::size_t rows = model.radiance.raw.topology->rows();
  for (std::size_t r = kBrickRows; r < rows; ++r) model.radiance.raw.row(r)[0] = 6;
  return model;
}

HeldCamera held(const VoxelModel& model, const Dataset& data) {
  Renderer renderer(model);
  const auto out = held_camera_test(model, renderer, *data.find("train"), *data.find("val"));
  REQUIRE(out);
  return *out;
}

}  // namespace

TEST_SUITE("app/held_camera") {
  TEST_CASE("without motion nothing moves, nor with one that is 0; nobody is warned") {
    const Dataset& data = still_film();
    for (const VoxelModel& model : {block({}, false), block({})}) {
      const HeldCamera h = held(model, data);
      CHECK(h.median == 0);
      CHECK(h.p95 == 0);
      CHECK(h.proved_share > 0.25);
      CHECK(h.proved_share <= 1);
      CHECK(held_camera_warning(h).empty());
    }
  }
  TEST_CASE("a model that drifts while the camera goes shows its drift, in pixels of the picture") {
    const Dataset& data = still_film();
    const HeldCamera once = held(block({0, 0, 0.1f}), data), twice = held(block({0, 0, 0.2f}), data);
    // Focal length times drift over distance, by the time that passes; the camera looks down a little.
    const double all_the_way = 133 * 0.1 / 3.4;
    CHECK(once.p95 > 0.5 * all_the_way);
    CHECK(once.p95 < 1.1 * all_the_way);
    CHECK(once.p95_share == doctest::Approx(once.p95 / 96));
    CHECK(once.median > 0);
    CHECK(once.median < once.p95);
    CHECK(twice.p95 > 1.7 * once.p95);
    CHECK(twice.p95 < 2.3 * once.p95);
    CHECK(held_camera_warning(twice).find("camera's motion was learned") != std::string::npos);
  }
  TEST_CASE("pictures prove what stands still, and hardly ever what moves") {
    const char* const scene = "dancer";
    const Dataset data = film(scene);
    const SynthScene truth = SynthScene::open(scene, {.opaque = true});
    std::vector<SmallPicture> pictures;
    for (const Frame& frame : data.find("val")->frames) pictures.push_back(small_picture(frame, {}));
    std::vector<double> times;
    for (int i = 0; i <= 16; ++i) times.push_back(i / 16.0);
    const PatchEvidence evidence(*data.find("train"), truth.box(), {}, times);
    const StillPlaces places = evidence.places(pictures, std::vector<PixelMask>(pictures.size()));
    REQUIRE(places.places.size() > 20);
    std::size_t still = 0, moving = 0;
    for (const StillPlace& place : places.places) {
      const SmallPicture& picture = pictures[place.picture];
      const auto hit = truth.at(picture.time).trace(camera_ray(picture.camera, place.u, place.v));
      if (!hit) continue;
      for (std::size_t t = 0; t < times.size(); ++t) {
        if (!place.still[t]) continue;
        CHECK(std::abs(times[t] - picture.time) >= kOtherTime);
        const Vec3d there = truth.at(times[t]).world_from_rest(hit->body, hit->rest);
        // Less than a pixel is still for anybody.
        ++(length(there - hit->position) < 0.03 ? still : moving);
      }
    }
    CHECK(double(moving) < 0.1 * double(still + moving));
  }
  TEST_CASE("pictures of nothing prove nothing, and then there is no figure") {
    Dataset data = still_film();
    for (Split& split : data.splits)
      for (Frame& frame : split.frames)
        frame.image = Picture(Image16{96, 96, std::vector<std::uint16_t>(4 * 96 * 96, 30000)});
    const VoxelModel model = block({0, 0, 0.1f});
    Renderer renderer(model);
    CHECK(!held_camera_test(model, renderer, *data.find("train"), *data.find("val")));
  }
  TEST_CASE("one camera on its way is a film, cameras anywhere are not") {
    const Box box = block({}).box;
    for (const double orbit : {0.1, 0.5, 1.0}) {
      const Dataset data =
          make_synth("static", {.frames = 40, .size = 8, .orbit = orbit, .film = true, .shake = 0.02});
      CHECK(is_film(*data.find("train"), box));
    }
    CHECK(!is_film(*make_synth("static", {.frames = 40, .size = 8}).find("train"), box));
  }
}
