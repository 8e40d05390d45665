// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox {
namespace {

constexpr SynthOptions kRig{.frames = 6, .size = 48, .rig = {.cameras = 3}};

double mass(const SynthScene& scene, double time) {
  const SynthMoment moment = scene.at(time);
  const SynthVolume& v = *moment.gas();
  return std::accumulate(v.density.begin(), v.density.end(), 0.0) * std::pow(v.spacing, 3);
}

/// Colour times alpha, and alpha, of a pixel: many rays in many short steps through the volume.
struct Integral {
  Vec3d shown{};
  double alpha = 0;
};
Integral integrate(const SynthVolume& volume, const Camera& camera, int x, int y) {
  constexpr int kRays = 6, kSteps = 4000;
  constexpr double kNear = 2, kFar = 6;  // scene units: the volume lies between
  Integral out;
  for (int i = 0; i < kRays * kRays; ++i) {
    const Ray ray = camera_ray(camera, x + (i % kRays + 0.5) / kRays, y + (i / kRays + 0.5) / kRays);
    double depth = 0;  // optical
    for (int k = 0; k < kSteps; ++k) {
      const double dt = (kFar - kNear) / kSteps;
      const SynthVolume::Sample s = volume.at(ray.origin + (kNear + (k + 0.5) * dt) * ray.direction);
      out.shown += std::exp(-depth) * (1 - std::exp(-s.density * dt)) / (kRays * kRays) * s.colour;
      depth += s.density * dt;
    }
    out.alpha += (1 - std::exp(-depth)) / (kRays * kRays);
  }
  return out;
}

}  // namespace

TEST_SUITE("data/synth gas") {
  TEST_CASE(
      "pictures show the volume: alpha and colour are its integrals along the pixels' rays, in 8 bits") {
    for (const char* name : {"smoke", "fire"}) {
      CAPTURE(name);
      const SynthScene scene = SynthScene::open(name);
      const Dataset data = make_synth(name, kRig);
      double worst_alpha = 0, worst_shown = 0;
      int seen = 0;
      for (const std::size_t f : {4, 9, 14}) {
        const Frame& frame = data.find("train")->frames[f];
        const SynthMoment moment = scene.at(frame.time);
        for (int y = 6; y < 48; y += 4)
          for (int x = 15; x < 33; x += 3) {
            const auto pixel = frame.image.pixel(x, y);
            const Integral truth = integrate(*moment.gas(), frame.camera, x, y);
            const double alpha = pixel[3] / 65535.0;
            seen += pixel[3] > 0;
            worst_alpha = std::max(worst_alpha, std::abs(alpha - truth.alpha));
            for (int c = 0; c < 3; ++c)
              worst_shown = std::max(worst_shown, std::abs(alpha * pixel[c] / 65535.0 - truth.shown[c]));
          }
      }
      CHECK(seen > 40);
      CHECK(worst_alpha < 1.5 / 255);
      CHECK(worst_shown < 2.0 / 255);  // both colour and alpha are rounded
    }
  }

  TEST_CASE(
      "smoke is born, grows and is nearly gone in the end; nothing of it is opaque or touches the border") {
    const SynthScene scene = SynthScene::open("smoke");
    CHECK(mass(scene, 0.5) > 1.5 * mass(scene, 0));
    CHECK(mass(scene, 1) < 0.6 * mass(scene, 0.6));
    CHECK(mass(scene, 1.3) == 0);
    const Dataset data = make_synth("smoke", kRig);
    int most = 0;
    for (const Frame& frame : data.find("train")->frames)
      for (std::size_t p = 0; p < frame.image.pixels(); ++p)
        most = std::max<int>(most, frame.image.pixel(p)[3]);
    CHECK(most > 0.5 * 65535);
    CHECK(most < 0.95 * 65535);
    const SynthMoment moment = scene.at(0.6);
    const SynthVolume& v = *moment.gas();
    double border = 0;
    for (int x = 0; x < v.size.x; ++x)
      for (int y = 0; y < v.size.y; ++y)
        for (int z = 0; z < v.size.z; ++z)
          if (x == 0 || y == 0 || z == 0 || x == v.size.x - 1 || y == v.size.y - 1 || z == v.size.z - 1)
            border += double(v.density[v.index({x, y, z})]);
    CHECK(border == 0);
    CHECK(*std::min_element(v.density.begin(), v.density.end()) == 0);
  }

  TEST_CASE(
      "fire changes more within a twentieth of the time than smoke, and is bright below and dark above") {
    const auto change = [](const char* name) {
      const SynthScene scene = SynthScene::open(name);
      const SynthMoment a = scene.at(0.5), b = scene.at(0.55);
      double apart = 0, all = 0;
      for (std::size_t i = 0; i < a.gas()->density.size(); ++i) {
        apart += std::abs(double(a.gas()->density[i]) - double(b.gas()->density[i]));
        all += double(a.gas()->density[i]);
      }
      return apart / all;
    };
    CHECK(change("fire") > 1.2 * change("smoke"));
    const SynthMoment moment = SynthScene::open("fire").at(0.5);
    const SynthVolume& v = *moment.gas();
    const auto red_and_green = [&](int from, int until) {
      double weight = 0;
      Vec3d sum{};
      for (int x = 0; x < v.size.x; ++x)
        for (int y = 0; y < v.size.y; ++y)
          for (int z = from; z < until; ++z) {
            const std::size_t i = v.index({x, y, z});
            weight += double(v.density[i]);
            sum += double(v.density[i]) * cast<double>(v.colour[i]);
          }
      return (1 / weight) * sum;
    };
    const Vec3d below = red_and_green(0, v.size.z / 4), above = red_and_green(v.size.z * 5 / 8, v.size.z);
    CHECK(below.y > 0.6);
    CHECK(above.y < 0.6 * below.y);
    CHECK(above.x < below.x);
  }

  TEST_CASE("gas has no surface; its pictures are the same on any number of threads") {
    const SynthScene scene = SynthScene::open("smoke");
    CHECK(scene.has_gas());
    CHECK_FALSE(SynthScene::open("dancer").has_gas());
    CHECK(SynthScene::open("dancer").at(0).gas() == nullptr);
    CHECK_FALSE(scene.at(0.5).trace({{4, 0, 0}, {-1, 0, 0}}).has_value());
    CHECK(scene.box().hi.x > 0.85f);
    const Dataset a = make_synth("smoke", kRig);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Dataset b = make_synth("smoke", kRig);
    CHECK(a.fingerprint == b.fingerprint);
    CHECK(a.has_alpha);
  }

  TEST_CASE("in a room smoke stands before the walls") {
    SynthOptions room = kRig;
    room.look.room = true;
    const Dataset with = make_synth("smoke", room);
    CHECK_FALSE(with.has_alpha);
    bool opaque = true, differs = false;
    const Frame &first = with.find("train")->frames[0], &later = with.find("train")->frames[9];
    for (std::size_t p = 0; p < first.image.pixels(); ++p) {
      opaque = opaque && first.image.pixel(p)[3] == 65535;
      differs = differs || first.image.pixel(p)[0] != later.image.pixel(p)[0];
    }
    CHECK(opaque);
    CHECK(differs);
  }

  TEST_CASE("who enters is in no picture at first and who leaves in none at the end; nothing else moves") {
    SynthOptions options = kRig;
    options.rig.cameras = 8;
    for (const char* name : {"enters", "leaves"}) {
      CAPTURE(name);
      const bool enters = std::string(name) == "enters";
      const Dataset data = make_synth(name, options);
      const std::vector<Frame>& frames = data.find("train")->frames;
      const SynthScene scene = SynthScene::open(name);
      const int ball = scene.at(0).bodies() - 1;
      const auto shown = [&](const Frame& frame) {
        const SynthMoment moment = scene.at(frame.time);
        int pixels = 0;
        for (int y = 0; y < 48; ++y)
          for (int x = 0; x < 48; ++x) {
            const auto hit = moment.trace(camera_ray(frame.camera, x + 0.5, y + 0.5));
            pixels += hit && hit->body == ball;
          }
        return pixels;
      };
      int at_first = 0, at_last = 0;
      for (std::size_t k = 0; k < 8; ++k) {
        at_first += shown(frames[k]);
        at_last += shown(frames[frames.size() - 8 + k]);
      }
      CHECK((enters ? at_first : at_last) == 0);
      CHECK((enters ? at_last : at_first) > 8 * 10);
      const SynthMoment then = scene.at(0), now = scene.at(1);
      for (int body = 0; body < ball; ++body)
        CHECK(length(now.world_from_rest(body, {0.1, 0.1, 0.1}) -
                     then.world_from_rest(body, {0.1, 0.1, 0.1})) == 0);
    }
  }
}

}  // namespace splinevox
