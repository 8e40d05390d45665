// SPDX-License-Identifier: Apache-2.0
#include "data/synth/view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <span>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr double kDistance = 4.0;
constexpr double kWall = 0.5;  ///< grey behind opaque pictures

Camera camera_at(double azimuth, double elevation, int size) {
  Camera camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = 0.5 * size / std::tan(0.5 * kCameraAngle);
  camera.cx = camera.cy = 0.5 * size;
  const Vec3d back{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                   std::sin(elevation)};
  const Vec3d right{-std::sin(azimuth), std::cos(azimuth), 0};
  camera.axes = {right, cross(back, right), back};
  camera.position = kDistance * back;
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

/// 53 random bits as a number in [0, 1); the same on every standard library.
double draw_unit(std::mt19937_64& rng) { return double(rng() >> 11) / double(1ull << 53); }

struct Sample {
  int body = -1;
  Vec3d colour{};
};

Sample look(const SynthMoment& moment, const Camera& camera, double u, double v) {
  const auto hit = moment.trace(camera_ray(camera, u, v));
  return hit ? Sample{hit->body, hit->colour} : Sample{};
}

bool one_body(std::span<const Sample> samples) {
  return std::all_of(samples.begin(), samples.end(),
                     [&](const Sample& s) { return s.body == samples[0].body; });
}

/// Largest difference of any colour component.
double contrast(std::span<const Sample> samples) {
  Vec3d lo = samples[0].colour, hi = lo;
  for (const Sample& s : samples) {
    lo = min(lo, s.colour);
    hi = max(hi, s.colour);
  }
  return std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z});
}

void average(std::span<const Sample> samples, float* rgba) {
  Vec3d sum{};
  int hits = 0;
  for (const Sample& s : samples) {
    if (s.body < 0) continue;
    sum += s.colour;
    ++hits;
  }
  if (hits > 0) sum *= 1.0 / hits;
  const double values[4] = {sum.x, sum.y, sum.z, double(hits) / double(samples.size())};
  for (int c = 0; c < 4; ++c) rgba[c] = float(std::floor(values[c] * 255 + 0.5)) / 255.0f;
}

/// Four samples; eight where the paint differs, sixteen where bodies do.
void draw_pixel(const SynthMoment& moment, const Camera& camera, int x, int y, float* rgba) {
  constexpr double kContrast = 0.1;
  static constexpr double kFew[8][2] = {{0.125, 0.375}, {0.625, 0.125}, {0.375, 0.875}, {0.875, 0.625},
                                        {0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}};
  std::array<Sample, 16> samples;
  const std::span four = std::span(samples).first(4), eight = std::span(samples).first(8);
  for (std::size_t i = 0; i < 4; ++i) samples[i] = look(moment, camera, x + kFew[i][0], y + kFew[i][1]);
  if (one_body(four) && contrast(four) < kContrast) return average(four, rgba);
  if (one_body(four)) {
    for (std::size_t i = 4; i < 8; ++i) samples[i] = look(moment, camera, x + kFew[i][0], y + kFew[i][1]);
    if (one_body(eight)) return average(eight, rgba);
  }
  for (int i = 0; i < 16; ++i)
    samples[std::size_t(i)] = look(moment, camera, x + (i % 4 + 0.5) / 4, y + (i / 4 + 0.5) / 4);
  average(samples, rgba);
}

}  // namespace

std::vector<SynthShot> plan_shots(const SynthOptions& options) {
  require(options.frames >= 2 && options.frames <= 10000, "frames", "2 to 10000", options.frames);
  require(options.size >= 8 && options.size <= 4096, "size", "8 to 4096 pixels", options.size);
  require(std::abs(options.orbit) <= 100, "orbit", "-100 to 100 times around", options.orbit);
  std::mt19937_64 rng(options.seed);
  std::vector<SynthShot> shots;
  const auto add = [&](const char* split, int count, auto&& camera) {
    for (int i = 0; i < count; ++i) {
      char name[16];
      std::snprintf(name, sizeof name, "r_%03d", i);
      const double t = double(i) / (count - 1);
      shots.push_back({split, name, t, camera(t)});
    }
  };
  const double from = options.orbit != 0 ? draw_unit(rng) : 0;  // of a turn
  add("train", options.frames, [&](double t) {
    if (options.orbit != 0)
      return camera_at(2 * M_PI * (from + options.orbit * t), 0.4 + 0.2 * std::sin(2 * M_PI * t),
                       options.size);
    const double azimuth = 2 * M_PI * draw_unit(rng), height = 0.05 + 0.85 * draw_unit(rng);
    return camera_at(azimuth, std::asin(height), options.size);
  });
  add("val", std::max(2, options.frames / 10), [&](double t) {
    return camera_at(2 * M_PI * t + 0.4, 0.6 - 0.25 * std::cos(2 * M_PI * t), options.size);
  });
  add("test", std::max(2, options.frames / 5), [&](double t) {
    return camera_at(2 * M_PI * t - 1.2, 0.5 + 0.2 * std::sin(4 * M_PI * t), options.size);
  });
  return shots;
}

Image draw(const SynthMoment& moment, const Camera& camera, bool opaque) {
  Image image(camera.width, camera.height, 4);
  parallel_for(camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      float* const rgba = image.pixel(x, y);
      draw_pixel(moment, camera, x, y, rgba);
      if (!opaque) continue;
      for (int c = 0; c < 3; ++c)
        rgba[c] = float(std::floor(255 * (rgba[3] * rgba[c] + (1 - rgba[3]) * kWall) + 0.5)) / 255.0f;
      rgba[3] = 1;
    }
  });
  return image;
}

std::vector<ExrLayer> draw_truth(const SynthMoment& moment, const Camera& camera) {
  const int w = camera.width, h = camera.height;
  std::vector<ExrLayer> layers{{"position", Image(w, h, 3), {"X", "Y", "Z"}},
                               {"rest", Image(w, h, 3), {"R", "G", "B"}},
                               {"depth", Image(w, h, 1), {}}};
  parallel_for(h, [&](int y) {
    for (int x = 0; x < w; ++x) {
      const auto hit = moment.trace(camera_ray(camera, x + 0.5, y + 0.5));
      if (!hit) continue;
      for (int c = 0; c < 3; ++c) {
        layers[0].image.pixel(x, y)[c] = float(hit->position[c]);
        layers[1].image.pixel(x, y)[c] = float(hit->rest[c]);
      }
      *layers[2].image.pixel(x, y) = float(project(camera, hit->position).depth);
    }
  });
  return layers;
}

}  // namespace splinevox::data
