// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox {
namespace {

constexpr double kDistance = 4;  ///< of cameras that are not in a room

Dataset film(double shake, std::uint64_t seed = 1) {
  return make_synth("ball",
                    {.frames = 31, .size = 8, .seed = seed, .orbit = 0.3, .film = true, .shake = shake});
}

/// The least distance of a camera from those of the training pictures, at any time or near one.
double from_the_way(const Dataset& data, const Frame& frame, double within) {
  double least = HUGE_VAL;
  for (const Frame& f : data.find("train")->frames)
    if (std::abs(f.time - frame.time) < within)
      least = std::min(least, length(f.camera.position - frame.camera.position));
  return least;
}

bool refused(const SynthOptions& options) {
  try {
    make_synth("ball", options);
  } catch (const Error& error) {
    return error.fault == Fault::input;
  }
  return false;
}

}  // namespace

TEST_SUITE("data/synth_film") {
  TEST_CASE("a film in an even hand has the training pictures of its orbit") {
    const Dataset data = film(0), orbit = make_synth("ball", {.frames = 31, .size = 8, .orbit = 0.3});
    for (std::size_t i = 0; i < 31; ++i) {
      const Frame &a = data.find("train")->frames[i], &b = orbit.find("train")->frames[i];
      CHECK(a.time == b.time);
      CHECK(length(a.camera.position - b.camera.position) < 1e-12);
      CHECK(a.image == b.image);
    }
  }
  TEST_CASE(
      "val pictures lie on the camera's way between training times, test pictures off it at such times") {
    const Dataset data = film(0.02);
    for (const Frame& f : data.find("val")->frames) {
      CHECK(from_the_way(data, f, 0.02) < 0.2);
      CHECK(std::abs(std::remainder(30 * f.time, 1.0)) == doctest::Approx(0.5));
    }
    CHECK(data.find("test")->frames.size() == 6);
    for (const Frame& f : data.find("test")->frames) {
      CHECK(from_the_way(data, f, 0.02) > 1);
      CHECK(from_the_way(data, f, 2) < 1);  // somewhere on its way the film shows the same
      CHECK(std::abs(std::remainder(30 * f.time, 1.0)) < 1e-9);
    }
  }
  TEST_CASE("a hand shakes as far as asked, smoothly, and the same for one seed") {
    const Dataset even = film(0), held = film(0.05), again = film(0.05), other = film(0.05, 2);
    double square = 0, turned = 0, step = 0;
    Vec3d last{};
    for (std::size_t i = 0; i < 31; ++i) {
      const Camera &a = even.find("train")->frames[i].camera, &b = held.find("train")->frames[i].camera;
      const Vec3d by = b.position - a.position;
      square += dot(by, by) / 31;
      turned = std::max(turned, std::acos(std::min(1.0, dot(a.axes[2], b.axes[2]))));
      if (i > 0) step = std::max(step, length(by - last));
      last = by;
      for (int k = 0; k < 3; ++k) {
        CHECK(length(b.axes[std::size_t(k)]) == doctest::Approx(1));
        CHECK(std::abs(dot(b.axes[std::size_t(k)], b.axes[std::size_t((k + 1) % 3)])) < 1e-12);
      }
      CHECK(b.position == again.find("train")->frames[i].camera.position);
    }
    const double expected = 0.05 * kDistance * std::sqrt(3.0);
    CHECK(std::sqrt(square) > 0.4 * expected);
    CHECK(std::sqrt(square) < 2 * expected);
    CHECK(turned > 0.02);
    CHECK(turned < 0.4);
    CHECK(step < 1.5 * expected);
    CHECK(other.find("train")->frames[3].camera.position != held.find("train")->frames[3].camera.position);
  }
  TEST_CASE("a film needs an orbit, a hand needs a film, and no hand shakes without bound") {
    CHECK(refused({.film = true}));
    CHECK(refused({.orbit = 0.5, .shake = 0.1}));
    CHECK(refused({.orbit = 0.5, .film = true, .shake = 0.3}));
    CHECK(refused({.orbit = 0.5, .film = true, .shake = std::nan("")}));
  }
}

}  // namespace splinevox
