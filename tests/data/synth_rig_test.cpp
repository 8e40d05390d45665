// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "expect_error.hpp"
#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/synth.hpp"
#include "support/tiny_dataset.hpp"

namespace splinevox {
namespace {

TEST_SUITE("data/synth_rig") {
  TEST_CASE("in a room every ray meets something, and what is not the scene's own stands still") {
    const SynthScene scene = SynthScene::open("dancer", {.room = true});
    const SynthMoment first = scene.at(0), later = scene.at(0.4);
    CHECK(first.subjects() == SynthScene::open("dancer").at(0).bodies());
    CHECK(first.bodies() > first.subjects());
    const Camera camera =
        make_synth("ball", {.frames = 2, .size = 80, .look = {.room = true}}).find("test")->frames[0].camera;
    int hits = 0, of_room = 0, moved = 0;
    double off = 0;
    for (int y = 0; y < camera.height; y += 3)
      for (int x = 0; x < camera.width; x += 3) {
        const auto hit = later.trace(camera_ray(camera, x + 0.5, y + 0.5));
        if (!hit) continue;
        ++hits;
        off = std::max(off, std::abs(later.distance(hit->body, hit->position)));
        if (hit->body < later.subjects()) continue;
        ++of_room;
        moved += length(hit->rest - hit->position) > 1e-9;
      }
    CHECK(hits == 27 * 27);
    CHECK(of_room > hits / 3);
    CHECK(moved == 0);
    CHECK(off < 1e-7);
  }

  TEST_CASE("a rig stands still, sees every moment or takes turns, and is tested by other cameras") {
    const SynthOptions options{.frames = 10, .size = 8, .seed = 1, .rig = {.cameras = 3}};
    const Dataset all = make_synth("ball", options);
    REQUIRE(all.cameras.size() == 6);
    const std::vector<Frame>& train = all.find("train")->frames;
    REQUIRE(train.size() == 30);
    for (std::size_t i = 0; i < train.size(); ++i) {
      CHECK(train[i].camera_id == int(i % 3));
      CHECK(train[i].time == double(i / 3) / 9);
      CHECK(train[i].camera.position == train[i % 3].camera.position);
    }
    for (const Frame& f : all.find("test")->frames) CHECK((f.camera_id == 4 || f.camera_id == 5));
    for (const Frame& f : all.find("val")->frames) CHECK(f.camera_id == 3);
    for (const RigCamera& camera : all.cameras) CHECK(camera.still);
    SynthOptions turns = options;
    turns.rig.turns = true;
    const Dataset one = make_synth("ball", turns);
    REQUIRE(one.find("train")->frames.size() == 10);
    for (int i = 0; i < 10; ++i) CHECK(one.find("train")->frames[std::size_t(i)].camera_id == i % 3);
  }

  TEST_CASE("a rig's folder loads back with its cameras, and truth.json says gains and clocks") {
    const test::TempFolder folder;
    const std::string path = (folder.path() / "rig").string();
    const SynthOptions options{.frames = 5,
                               .size = 24,
                               .seed = 2,
                               .look = {.room = true},
                               .rig = {.cameras = 4, .exposures = 0.2, .late = 0.5, .masks = true}};
    write_synth("toy", path, options);
    const Dataset loaded = load_dataset(path), made = make_synth("toy", options);
    CHECK(!loaded.has_alpha);
    CHECK(!made.has_alpha);
    REQUIRE(loaded.cameras.size() == made.cameras.size());
    for (std::size_t c = 0; c < made.cameras.size(); ++c) {
      CHECK(loaded.cameras[c].name == made.cameras[c].name);
      CHECK(loaded.cameras[c].still == made.cameras[c].still);
    }
    for (std::size_t s = 0; s < made.splits.size(); ++s)
      for (std::size_t i = 0; i < made.splits[s].frames.size(); ++i) {
        CHECK(loaded.splits[s].frames[i].image == made.splits[s].frames[i].image);
        CHECK(loaded.splits[s].frames[i].camera_id == made.splits[s].frames[i].camera_id);
      }
    std::ifstream file(path + "/truth.json");
    const nlohmann::json truth = nlohmann::json::parse(file);
    double product[3] = {1, 1, 1}, widest = 0;
    for (const std::string camera : {"cam00", "cam01", "cam02", "cam03"}) {
      CHECK(truth["time_offset_intervals"][camera] == (camera == "cam01" ? 0.5 : 0.0));
      CHECK(truth["time_offset"][camera] == (camera == "cam01" ? 0.125 : 0.0));
      for (std::size_t c = 0; c < 3; ++c) {
        const double gain = truth["gains"][camera][c];
        product[c] *= gain;
        widest = std::max(widest, std::abs(gain - 1));
      }
    }
    for (const double p : product) CHECK(p == doctest::Approx(1));
    CHECK(widest > 0.02);
    CHECK(widest < 0.45);
    CHECK(truth["gains"]["cam04"] == nlohmann::json({1.0, 1.0, 1.0}));
    CHECK(truth["scene_box"][0][0] < -2.8);
    const Image16 mask = read_png(path + "/masks/train/cam00_0000.png");
    REQUIRE(mask.width == 24);
    int white = 0, black = 0;
    for (std::size_t i = 0; i < mask.rgba.size(); i += 4) {
      white += mask.rgba[i] == 65535;
      black += mask.rgba[i] == 0;
    }
    CHECK(white > 30);
    CHECK(black > 150);
  }

  TEST_CASE("a camera's picture is the neutral one times its gain, at the moment its clock means") {
    SynthOptions plain{.frames = 5, .size = 24, .seed = 2, .rig = {.cameras = 2}}, other = plain;
    other.rig.late = 1;
    const Dataset a = make_synth("ball", plain), b = make_synth("ball", other);
    const auto at = [](const Dataset& data, int moment, int camera) {
      return data.find("train")->frames[std::size_t(2 * moment + camera)].image;
    };
    for (int moment = 0; moment < 4; ++moment) {
      CHECK(at(b, moment, 0) == at(a, moment, 0));
      CHECK(at(b, moment, 1) == at(a, moment + 1, 1));
    }
    CHECK(!(at(b, 4, 1) == at(a, 4, 1)));  // the motion goes on
    other = plain;
    other.rig.exposures = 0.1;
    const Dataset c = make_synth("ball", other);
    for (std::size_t f = 0; f < 2; ++f) {
      const Picture &neutral = a.find("train")->frames[f].image, &exposed = c.find("train")->frames[f].image;
      double lo = 2, hi = 0;
      for (std::size_t i = 0; i < neutral.pixels(); ++i) {
        const auto n = neutral.pixel(i), e = exposed.pixel(i);
        CHECK(n[3] == e[3]);
        if (n[0] < 20000 || e[0] == 65535) continue;
        lo = std::min(lo, double(e[0]) / n[0]);
        hi = std::max(hi, double(e[0]) / n[0]);
      }
      CHECK(hi - lo < 0.02);  // roundings
      CHECK(std::abs(lo - 1) < 0.2);
    }
    CHECK(c.find("test")->frames[0].image == a.find("test")->frames[0].image);
  }

  TEST_CASE("options of a rig that contradict each other or are out of range are refused by name") {
    const auto said = [](const SynthOptions& o) { return test::error_of([&] { make_synth("ball", o); }); };
    CHECK(said({.rig = {.cameras = 1}}).starts_with("synth, cameras: out of range"));
    CHECK(said({.rig = {.turns = true}}).starts_with("synth, cameras: out of range"));
    CHECK(said({.rig = {.cameras = 3, .exposures = 0.6}}).starts_with("synth, exposures"));
    CHECK(said({.rig = {.cameras = 3, .late = std::nan("")}}).starts_with("synth, offsets"));
    CHECK(said({.orbit = 1, .rig = {.cameras = 3}}).starts_with("synth, orbit"));
  }
}

}  // namespace
}  // namespace splinevox
