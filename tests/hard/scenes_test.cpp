// SPDX-License-Identifier: Apache-2.0
// Hard scenes from end to end: each ends by its budget, holds nothing that is not finite, and shows what it
// should.
#include "hard/scenes.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <limits>

#include "data/pictures/exr.hpp"
#include "data/truth.hpp"
#include "hard/measured.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

const Split& train() { return *ball().find("train"); }
const Split& held_out() { return *ball().find("test"); }

/// PSNR of the plain scene: what the hard ones are compared with.
double plain() {
  static const double db = quality(plain_model(), held_out());
  return db;
}

}  // namespace

TEST_SUITE("hard/scenes") {
  TEST_CASE("the plain scene is learned") { measured_least("scene plain", plain(), 26, "dB"); }
  TEST_CASE("H30: all dark: pixels times 0.01 are learned like the others, seen at the same brightness") {
    Config config = short_run();
    config.run.background = {0, 0, 0};
    const auto dim = [](double(&v)[4]) {
      for (int c = 0; c < 3; ++c) v[c] *= 0.01;
    };
    config.run.max_steps = 400;
    const double bright = quality(trained(config, train()), held_out());
    const double dark = quality(trained(config, repainted(train(), dim)), repainted(held_out(), dim), 100);
    measured_least("H30 dark minus bright, over black", dark - bright, -1, "dB");
  }
  TEST_CASE("H30: pixels times 0.001 are less than half a level of 8 bits, and not taken for emptiness") {
    Config config = short_run();
    config.run.background = {0, 0, 0};
    config.grid.empty_start = {0.5f, 0.8f};
    const auto dim = [](double(&v)[4]) {
      for (int c = 0; c < 3; ++c) v[c] *= 0.001;
    };
    const double bright = quality(trained(config, train()), held_out());
    const double dark = quality(trained(config, repainted(train(), dim)), repainted(held_out(), dim), 1000);
    measured_least("H30 a thousandth minus bright, over black", dark - bright, -2, "dB");
  }
  TEST_CASE("H32: all white, opaque: the picture is white") {
    const auto white = [](double(&v)[4]) { std::fill_n(v, 4, 1.0); };
    measured_least("H32 all white",
                   quality(trained(short_run(150), repainted(train(), white)), repainted(held_out(), white)),
                   27, "dB");
  }
  TEST_CASE("H32: nothing but transparent pixels: the picture is the background") {
    const auto nothing = [](double(&v)[4]) { std::fill_n(v, 4, 0.0); };
    measured_least(
        "H32 empty pictures",
        quality(trained(short_run(30), repainted(train(), nothing)), repainted(held_out(), nothing)), 36,
        "dB");
  }
  TEST_CASE("H32: one frame") {
    Split one{"train", {train().frames[5]}};
    one.frames[0].time = 0;
    measured_least("H32 one frame, its own picture", quality(trained(short_run(), one, {0.2, 0}), one), 28,
                   "dB");
  }
  TEST_CASE("H32: one pixel") {
    Split split = train();
    for (Frame& f : split.frames) {
      f.camera = {1, 1, 1.2, 1.2, 0.5, 0.5, f.camera.axes, f.camera.position};
      f.image = Image16{1, 1, {52428, 26214, 13107, 65535}};
    }
    measured_least("H32 pictures of one pixel", quality(trained(short_run(30), split), split), 20, "dB");
    Split single{"train", {split.frames[0]}};
    measured_least("H32 one picture of one pixel", quality(trained(short_run(30), single), single), 20, "dB");
  }
  TEST_CASE("H6: all frames at one time") {
    Dataset data = make_synth("static", {.frames = 24, .size = 40, .seed = 3});
    const double spread = quality(trained(short_run(), *data.find("train")), *data.find("test"));
    for (Split& s : data.splits)
      for (Frame& f : s.frames) f.time = 0;
    const double together = quality(trained(short_run(), *data.find("train"), {0.4, 0}), *data.find("test"));
    measured_least("H6 one common time minus times apart", together - spread, -0.5, "dB");
  }
  TEST_CASE("H6: every time twice") {
    Split both = *make_synth("ball", {.frames = 12, .size = 40, .seed = 3}).find("train");
    const Dataset more = make_synth("ball", {.frames = 12, .size = 40, .seed = 4});
    both.frames.insert(both.frames.end(), more.find("train")->frames.begin(),
                       more.find("train")->frames.end());
    measured_least("H6 twelve times seen twice minus plain",
                   quality(trained(short_run(), both), held_out()) - plain(), -1.5, "dB");
  }
  TEST_CASE("H5: a gap of 30% of the time: as good outside, sensible inside") {
    Split gap = train();
    const auto inside = [](double t) { return t > 0.35 && t < 0.65; };
    std::erase_if(gap.frames, [&](const Frame& f) { return inside(f.time); });
    const VoxelModel model = trained(short_run(), gap);
    measured_least("H5 outside a gap, minus plain", quality(model, held_out()) - plain(), -4.5, "dB");
    // The pictures taken out of the training set.
    measured_least("H5 inside the gap", quality(model, train(), 1, inside), 18, "dB");
  }
  TEST_CASE("H5: 12 control points on 15 frames: between them as good as at them") {
    const Dataset few = make_synth("ball", {.frames = 15, .size = 40, .seed = 3});
    Config config = short_run();
    CHECK(config.motion.points == 12);
    const VoxelModel model = trained(config, *few.find("train"));
    measured_least("H5 12 points on 15 frames, times between, minus plain",
                   quality(model, held_out()) - plain(), -2.5, "dB");
  }
  TEST_CASE("H28: cameras inside the object") {
    // A shell around the cameras, painted by direction; cameras near its middle look outwards.
    Split split{"train", {}};
    for (const Frame& f : train().frames) {
      Frame inner = f;
      inner.time = 0;
      inner.camera.position = 0.05 * f.camera.position;
      for (int a : {0, 2}) inner.camera.axes[a] = -inner.camera.axes[a];  // half a turn: away from the middle
      Image16 image = f.image.unpacked();
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
          const Ray ray = camera_ray(inner.camera, x + 0.5, y + 0.5);
          // Where it meets the sphere of radius 2.
          const double b = dot(ray.origin, ray.direction),
                       s = -b + std::sqrt(b * b + 4 - dot(ray.origin, ray.origin));
          const Vec3d p = 0.5 * (ray.origin + s * ray.direction);
          std::uint16_t* to = image.rgba.data() + 4 * (std::size_t(y) * 40 + x);
          for (int c = 0; c < 3; ++c) to[c] = std::uint16_t(65535 * (0.5 + 0.4 * p[c]));
          to[3] = 65535;
        }
      inner.image = image;
      split.frames.push_back(inner);
    }
    Config config = short_run();
    config.motion.enabled = false;
    Split kept{"test", {}}, rest{"train", {}};
    for (std::size_t i = 0; i < split.frames.size(); ++i)
      (i % 6 == 3 ? kept : rest).frames.push_back(split.frames[i]);
    const VoxelModel model = trained(config, rest);
    measured_least("H28 cameras inside the object, held-out views", quality(model, kept), 22, "dB");
  }
  TEST_CASE(
      "H14: other units and places: the same scene a thousand times larger or smaller, and a million away") {
    for (const double scale : {1e-3, 1e3}) {
      CAPTURE(scale);
      measured_least(
          "H14 scaled by 1e-3 or 1e3, minus plain",
          quality(trained(short_run(), moved(train(), scale, {})), moved(held_out(), scale, {})) - plain(),
          -0.7, "dB");
    }
    // Where floats can no longer tell cells apart, the user is told what to do instead of getting a blur.
    const Vec3d away{1e6, -1e6, 1e6};
    for (const double scale : {1e-3, 1.0}) {
      try {
        trained(short_run(), moved(train(), scale, away));
        FAIL("a scene too far from the origin was taken");
      } catch (const Error& error) {
        CHECK(error.fault == Fault::input);
        CHECK(error.problem.what == "the scene lies too far from the origin for its size");
        CHECK(error.problem.hint.find("subtract (1000000") == 0);
      }
    }
    measured_least(
        "H14 scaled by 1e3 and moved by 1e6, minus plain",
        quality(trained(short_run(), moved(train(), 1e3, away)), moved(held_out(), 1e3, away)) - plain(),
        -0.7, "dB");
  }
  TEST_CASE("H29: pixels of the motion truth that are no numbers are left out, and nothing else changes") {
    const TempFolder folder;
    const double nan = std::nan("");
    const Camera camera{9, 9, 100, 100, 4.5, 4.5, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}, {}};
    Split split{"test", {Frame{"r_000", camera, 0.5, {}, -1}}};
    const auto points_with = [&](float poison, bool in_rest) {
      Image position{9, 9, 3}, rest{9, 9, 3};
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x)
          for (int c = 0; c < 3; ++c) {
            position.pixel(x, y)[c] = float(camera_ray(camera, x + 0.5, y + 0.5).direction[c]);
            rest.pixel(x, y)[c] = position.pixel(x, y)[c] - 0.5f;
          }
      (in_rest ? rest : position).pixel(4, 5)[1] = poison;
      std::filesystem::create_directories(folder.path() / "truth");
      write_exr((folder.path() / "truth/r_000_0000.exr").string(),
                {{"position", position, {"X", "Y", "Z"}}, {"rest", rest, {"R", "G", "B"}}});
      return read_truth(folder.str(), split, 0.5f)[0];
    };
    for (const bool in_rest : {false, true}) {
      // What a far-off value masks is what a NaN must mask.
      const SurfaceFrame masked = points_with(1e6f, in_rest);
      CHECK(masked.position.size() == 49 - 9);
      for (const double poison : {nan, double(INFINITY), -double(INFINITY)}) {
        const SurfaceFrame got = points_with(float(poison), in_rest);
        CHECK(got.position == masked.position);
        CHECK(got.rest == masked.rest);
      }
    }
  }
}
