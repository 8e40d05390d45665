// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "data/synth/view.hpp"
#include "data/synth/way.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

/// How far cameras are from the origin and how wide they see.
struct Reach {
  double distance, angle;  ///< scene units; full horizontal field of view, radians
};
Reach reach_in(const SynthLook& look) {
  return look.room ? Reach{2.6, 0.9} : Reach{4.0, 0.6911112070083618};  // D-NeRF's
}
constexpr int kTestCameras = 2;  ///< of a rig
constexpr int kLateEvery = 8;    ///< training cameras, of which one is late
constexpr double kRaised = 0.1;  ///< of a film's test cameras above its way, radians

Camera camera_at(double azimuth, double elevation, const SynthOptions& options) {
  const Reach reach = reach_in(options.look);
  Camera camera;
  camera.width = camera.height = options.size;
  camera.fx = camera.fy = 0.5 * options.size / std::tan(0.5 * reach.angle);
  camera.cx = camera.cy = 0.5 * options.size;
  const Vec3d back{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                   std::sin(elevation)};
  const Vec3d right{-std::sin(azimuth), std::cos(azimuth), 0};
  camera.axes = {right, cross(back, right), back};
  camera.position = reach.distance * back;
  return camera;
}

void require(bool ok, const char* field, const char* expected, double got) {
  if (!ok)
    fail({.where = std::string("synth, ") + field,
          .what = "out of range",
          .expected = expected,
          .got = fmt::format("{}", got),
          .hint = {}});
}

void check(const SynthOptions& options) {
  const SynthRig& rig = options.rig;
  require(options.frames >= 2 && options.frames <= 10000, "frames", "2 to 10000", options.frames);
  require(options.size >= 8 && options.size <= 4096, "size", "8 to 4096 pixels", options.size);
  require(std::abs(options.orbit) <= 100, "orbit", "-100 to 100 times around", options.orbit);
  require(rig.cameras == 0 || (rig.cameras >= 2 && rig.cameras <= 100), "cameras", "2 to 100, or 0: no rig",
          rig.cameras);
  require(rig.arc > 0 && rig.arc <= 1, "arc", "above 0 and at most 1, the whole ring", rig.arc);
  require(rig.exposures >= 0 && rig.exposures <= 0.5, "exposures", "0 to 0.5", rig.exposures);
  require(std::abs(rig.late) <= 2, "offsets", "-2 to 2 intervals", rig.late);
  require(options.shake >= 0 && options.shake <= 0.2, "shake", "0 to 0.2", options.shake);
  require(options.drift >= 0 && options.drift <= 0.5, "drift", "0 to 0.5", options.drift);
  require(options.film || rig.cameras > 0 || options.drift == 0, "drift", "0 but in a film or a rig",
          options.drift);
  require(options.film || options.shake == 0, "shake", "0 but in a film", options.shake);
  require(options.orbit != 0 || !options.film, "orbit", "not 0, for a film", options.orbit);
  require(rig.cameras == 0 || options.orbit == 0, "orbit", "0 with a rig: its cameras stand still",
          options.orbit);
  const bool of_rig = rig.arc != 1 || rig.turns || rig.exposures != 0 || rig.late != 0;
  require(rig.cameras > 0 || !of_rig, "cameras", "2 to 100, for arc, turns, exposures or offsets",
          rig.cameras);
}

std::string numbered(int i) { return fmt::format("r_{:03d}", i); }

/// Gains of the training cameras, their geometric mean 1 in every channel.
std::vector<Vec3d> draw_gains(const SynthRig& rig, std::mt19937_64& rng) {
  std::vector<Vec3d> gains(std::size_t(rig.cameras), {1, 1, 1});
  if (rig.exposures == 0) return gains;
  Vec3d sum{};
  for (Vec3d& gain : gains)
    for (int c = 0; c < 3; ++c) {
      gain[c] = std::log(1 + rig.exposures * (2 * draw_unit(rng) - 1));
      sum[c] += gain[c] / rig.cameras;
    }
  for (Vec3d& gain : gains)
    for (int c = 0; c < 3; ++c) gain[c] = std::exp(gain[c] - sum[c]);
  return gains;
}

/// What the automatic exposure and white balance of a camera make of a moment: each camera in its own way,
/// the channels not quite alike.
Vec3d drifting(const SynthOptions& options, int camera, double time) {
  constexpr double kTurns = 1.5, kApart = 0.618;
  const double wave = std::sin(2 * M_PI * (kTurns * time + kApart * camera)) * std::log1p(options.drift);
  return {std::exp(wave), std::exp(0.9 * wave), std::exp(0.8 * wave)};
}

/// Cameras in a ring at two heights in turn, those of val and test between two of them.
std::vector<SynthShot> plan_rig(const SynthOptions& options) {
  const SynthRig& rig = options.rig;
  std::mt19937_64 rng(options.seed);
  const double from = draw_unit(rng), step = 2 * M_PI * rig.arc / rig.cameras;
  std::vector<Camera> cameras;
  for (int k = 0; k < rig.cameras; ++k) {
    const double turn = k + from + 0.3 * draw_unit(rng);
    cameras.push_back(camera_at(step * turn, (k % 2 ? 0.6 : 0.2) + 0.1 * draw_unit(rng), options));
  }
  const auto between = [&](double share) {
    cameras.push_back(camera_at(step * (std::floor(share * rig.cameras) + from + 0.65), 0.4, options));
  };
  between(0.25);  // of val
  for (int k = 0; k < kTestCameras; ++k) between(double(k) / kTestCameras);
  const std::vector<Vec3d> gains = draw_gains(rig, rng);

  std::vector<SynthShot> shots;
  const auto add = [&](const char* split, int camera, int moment, int moments) {
    SynthShot shot{split, {}, double(moment) / (moments - 1), cameras[std::size_t(camera)]};
    shot.name = fmt::format("{}_{:04d}", synth_camera_name(camera), moment);
    shot.camera_id = camera;
    if (camera < rig.cameras) {
      const Vec3d now = drifting(options, camera, shot.time);
      for (int c = 0; c < 3; ++c) shot.gain[c] = gains[std::size_t(camera)][c] * now[c];
      if (camera % kLateEvery == 1) shot.late = rig.late / (options.frames - 1);
    }
    shots.push_back(std::move(shot));
  };
  for (int moment = 0; moment < options.frames; ++moment)
    for (int k = 0; k < rig.cameras; ++k)
      if (!rig.turns || moment % rig.cameras == k) add("train", k, moment, options.frames);
  const int val = std::max(2, options.frames / 10), test = std::max(2, options.frames / 5);
  for (int moment = 0; moment < val; ++moment) add("val", rig.cameras, moment, val);
  for (int moment = 0; moment < test; ++moment)
    for (int k = 0; k < kTestCameras; ++k) add("test", rig.cameras + 1 + k, moment, test);
  return shots;
}

/// Where a camera that goes around is at a time, in an even hand.
/// @param from  of a turn: where it begins
Camera on_the_way(double from, double time, double raised, const SynthOptions& options) {
  return camera_at(2 * M_PI * (from + options.orbit * time), 0.4 + 0.2 * std::sin(2 * M_PI * time) + raised,
                   options);
}

/// One camera's way; val between its pictures, test where it is at another time.
std::vector<SynthShot> plan_film(const SynthOptions& options, std::mt19937_64& rng) {
  const double from = draw_unit(rng), distance = reach_in(options.look).distance;
  std::vector<SynthShot> shots;
  const Hand hand(options.shake, rng);
  const auto held = [&](double t) { return hand.hold(on_the_way(from, t, 0, options), distance, t); };
  const auto time_of = [&](double picture) { return picture / (options.frames - 1); };
  for (int i = 0; i < options.frames; ++i) {
    shots.push_back({"train", numbered(i), time_of(i), held(time_of(i))});
    shots.back().gain = drifting(options, 0, time_of(i));
  }
  const int val = std::max(2, options.frames / 10), test = std::max(2, options.frames / 5);
  for (int i = 0; i < val; ++i) {
    const double t = time_of(std::floor((i + 0.5) / val * (options.frames - 1)) + 0.5);
    shots.push_back({"val", numbered(i), t, held(t)});
  }
  for (int i = 0; i < test; ++i) {
    const double t = time_of(std::round(double(i) / (test - 1) * (options.frames - 1)));
    shots.push_back({"test", numbered(i), t, on_the_way(from, std::fmod(t + 0.5, 1), kRaised, options)});
  }
  return shots;
}

}  // namespace

double camera_angle(const SynthLook& look) { return reach_in(look).angle; }

std::string synth_camera_name(int camera_id) { return fmt::format("cam{:02d}", camera_id); }

std::vector<SynthShot> plan_shots(const SynthOptions& options) {
  check(options);
  if (options.rig.cameras > 0) return plan_rig(options);
  std::mt19937_64 rng(options.seed);
  if (options.film) return plan_film(options, rng);
  std::vector<SynthShot> shots;
  const auto add = [&](const char* split, int count, auto&& camera) {
    for (int i = 0; i < count; ++i) {
      const double t = double(i) / (count - 1);
      shots.push_back({split, numbered(i), t, camera(t)});
    }
  };
  const double from = options.orbit != 0 ? draw_unit(rng) : 0;  // of a turn
  add("train", options.frames, [&](double t) {
    if (options.orbit != 0) return on_the_way(from, t, 0, options);
    const double azimuth = 2 * M_PI * draw_unit(rng), height = 0.05 + 0.85 * draw_unit(rng);
    return camera_at(azimuth, std::asin(height), options);
  });
  add("val", std::max(2, options.frames / 10),
      [&](double t) { return camera_at(2 * M_PI * t + 0.4, 0.6 - 0.25 * std::cos(2 * M_PI * t), options); });
  add("test", std::max(2, options.frames / 5),
      [&](double t) { return camera_at(2 * M_PI * t - 1.2, 0.5 + 0.2 * std::sin(4 * M_PI * t), options); });
  return shots;
}

}  // namespace splinevox::data
