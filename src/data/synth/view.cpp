// SPDX-License-Identifier: Apache-2.0
#include "data/synth/view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "data/synth/gas.hpp"
#include "math/camera.hpp"

namespace splinevox::data {
namespace {

constexpr double kWall = 0.5;  ///< grey behind opaque pictures

struct Sample {
  int body = -1;
  Vec3d colour{};
  bool masked = false;
  double along = std::numeric_limits<double>::infinity();  ///< distance from the eye
};

/// What rays of a camera meet.
struct Looker {
  const SynthMoment& moment;
  const Camera& camera;
  const SynthMask& mask;

  Sample operator()(double u, double v) const {
    const auto hit = moment.trace(camera_ray(camera, u, v));
    return hit ? Sample{hit->body, hit->colour, mask(*hit), hit->along} : Sample{};
  }
};

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

float in_bytes(double value) { return float(std::floor(value * 255 + 0.5)) / 255.0f; }

/// What a pixel shows, straight, and how much of it is masked.
struct Pixel {
  float rgba[4], masked;
};

Pixel average(std::span<const Sample> samples) {
  Vec3d sum{};
  int hits = 0, masked = 0;
  for (const Sample& s : samples) {
    if (s.body < 0) continue;
    sum += s.colour;
    ++hits;
    masked += s.masked;
  }
  if (hits > 0) sum *= 1.0 / hits;
  const auto share = [&](int n) { return in_bytes(double(n) / double(samples.size())); };
  return {{in_bytes(sum.x), in_bytes(sum.y), in_bytes(sum.z), share(hits)}, share(masked)};
}

/// Four samples; eight where the paint differs, sixteen where bodies do.
Pixel draw_pixel(const Looker& look, int x, int y) {
  constexpr double kContrast = 0.1;
  static constexpr double kFew[8][2] = {{0.125, 0.375}, {0.625, 0.125}, {0.375, 0.875}, {0.875, 0.625},
                                        {0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}};
  std::array<Sample, 16> samples;
  const std::span four = std::span(samples).first(4), eight = std::span(samples).first(8);
  for (std::size_t i = 0; i < 4; ++i) samples[i] = look(x + kFew[i][0], y + kFew[i][1]);
  if (one_body(four) && contrast(four) < kContrast) return average(four);
  if (one_body(four)) {
    for (std::size_t i = 4; i < 8; ++i) samples[i] = look(x + kFew[i][0], y + kFew[i][1]);
    if (one_body(eight)) return average(eight);
  }
  for (int i = 0; i < 16; ++i) samples[std::size_t(i)] = look(x + (i % 4 + 0.5) / 4, y + (i / 4 + 0.5) / 4);
  return average(samples);
}

/// A pixel with gas before what is solid: four rays, sixteen where bodies differ.
Pixel draw_gas_pixel(const Looker& look, const SynthVolume& gas, int x, int y) {
  std::array<Sample, 16> solid;
  int n = 2;  // rays along an edge of the pixel
  const auto place = [&](int i) { return std::pair{x + (i % n + 0.5) / n, y + (i / n + 0.5) / n}; };
  const auto look_at_all = [&] {
    for (int i = 0; i < n * n; ++i) {
      const auto [u, v] = place(i);
      solid[std::size_t(i)] = look(u, v);
    }
    return std::span(solid).first(std::size_t(n * n));
  };
  if (!one_body(look_at_all())) {
    n = 4;
    look_at_all();
  }
  Vec3d shown{};
  double covered = 0, masked = 0;
  for (int i = 0; i < n * n; ++i) {
    const Sample& s = solid[std::size_t(i)];
    const auto [u, v] = place(i);
    const Gathered before = gather_along(gas, camera_ray(look.camera, u, v), s.along);
    const double through = before.transmittance;
    shown += before.emission + through * s.colour;
    covered += 1 - (s.body < 0 ? through : 0);
    masked += 1 - (s.masked ? 0 : through);
  }
  if (covered > 0) shown *= 1 / covered;
  const auto share = [&](double sum) { return in_bytes(sum / (n * n)); };
  return {{in_bytes(shown.x), in_bytes(shown.y), in_bytes(shown.z), share(covered)}, share(masked)};
}

}  // namespace

SynthMask subject_mask(const SynthMoment& moment) {
  return [subjects = moment.subjects()](const SynthHit& hit) { return hit.body < subjects; };
}

SynthMask moving_mask(const SynthScene& scene) {
  constexpr int kMoments = 16;
  constexpr double kStill = 1e-6;           // scene units
  constexpr double kGolden = 0.6180339887;  // so that no number of repeats meets one pose at all moments
  std::vector<SynthMoment> moments;
  for (int i = 0; i < kMoments; ++i) moments.push_back(scene.at(std::fmod(kGolden * i, 1.0)));
  return [moments](const SynthHit& hit) {
    return std::any_of(moments.begin(), moments.end(), [&](const SynthMoment& m) {
      return length(m.world_from_rest(hit.body, hit.rest) - hit.position) > kStill;
    });
  };
}

Drawn draw(const SynthMoment& moment, const Camera& camera, bool opaque, const Vec3d& gain,
           const SynthMask& mask) {
  Drawn out{Image(camera.width, camera.height, 4), Image(camera.width, camera.height, 1)};
  const SynthVolume* const gas = moment.gas();
  const bool exposed = gain != Vec3d{1, 1, 1};
  parallel_for(camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const Looker look{moment, camera, mask};
      const Pixel pixel = gas ? draw_gas_pixel(look, *gas, x, y) : draw_pixel(look, x, y);
      float* const rgba = std::copy_n(pixel.rgba, 4, out.picture.pixel(x, y)) - 4;
      *out.mask.pixel(x, y) = pixel.masked;
      if (opaque) {
        for (int c = 0; c < 3; ++c) rgba[c] = in_bytes(rgba[3] * rgba[c] + (1 - rgba[3]) * kWall);
        rgba[3] = 1;
      }
      for (int c = 0; exposed && c < 3; ++c) rgba[c] = in_bytes(std::min(1.0, gain[c] * rgba[c]));
    }
  });
  return out;
}

Image draw_depth(const SynthMoment& moment, const Camera& camera, DepthKind kind, std::uint64_t draw) {
  constexpr double kNear = 0.5, kFar = 2;  // of the scale, and a shift of at most half a unit
  const Rng rng(draw, 0);
  const double scale = kind == DepthKind::metric ? 1 : kNear + (kFar - kNear) * rng.uniform(0),
               shift = kind == DepthKind::metric ? 0 : rng.uniform(1) - 0.5;
  Image out(camera.width, camera.height, 1);
  parallel_for(camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x)
      if (const auto hit = moment.trace(camera_ray(camera, x + 0.5, y + 0.5))) {
        const double depth = project(camera, hit->position).depth;
        *out.pixel(x, y) = float(((kind == DepthKind::inverse ? 1 / depth : depth) - shift) / scale);
      }
  });
  return out;
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
