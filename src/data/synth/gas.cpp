// SPDX-License-Identifier: Apache-2.0
#include "data/synth/gas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "data/synth/paint.hpp"
#include "data/synth/way.hpp"
#include "math/trilinear.hpp"

namespace splinevox::data {
namespace {

constexpr double kVoxel = 1.0 / 32;
constexpr Int3 kVoxels{58, 58, 62};
constexpr double kSource = -0.78;     ///< height where matter is born
constexpr double kYoung = 0.12;       ///< share of a life until a puff is all there
constexpr double kFeatures = 5;       ///< of the detail, per scene unit
constexpr double kStepsPerVoxel = 2;  ///< of a ray: a trilinear function is nearly straight over a half
constexpr double kOpaque = 1e-4;      ///< transmittance from which what is behind no longer shows in 8 bits

/// One puff at one time.
struct Puff {
  Vec3d centre;
  double radius, density;
  Vec3d colour;
};

Vec3d colour_at(const Gas& gas, double age) {
  const double at = 3 * std::clamp(age, 0.0, 1.0);
  const int i = std::min(2, int(at));
  return mix(gas.colours[i], gas.colours[i + 1], at - i);
}

/// Those that are there. Every puff takes as many random numbers, whether it is there or not.
std::vector<Puff> puffs_at(const Gas& gas, double time, double light) {
  std::mt19937_64 rng(gas.seed);
  std::vector<Puff> out;
  for (int i = 0; i < gas.puffs; ++i) {
    const double phase = 2 * M_PI * draw_unit(rng), off_axis = std::sqrt(draw_unit(rng)),
                 speed = 0.8 + 0.4 * draw_unit(rng), strength = 0.4 + 1.2 * draw_unit(rng);
    const double born = gas.from + (gas.until - gas.from) * (i + draw_unit(rng)) / gas.puffs;
    const double age = (time - born) / gas.life;
    if (!(age > 0 && age < 1)) continue;
    const double angle = phase + gas.turn * age, away = gas.spread * off_axis * age;
    const double circle = 2 * M_PI * born, drawn_in = gas.source * (1 - age);
    const Vec3d centre{drawn_in * std::cos(circle) + away * std::cos(angle),
                       drawn_in * std::sin(circle) + away * std::sin(angle),
                       kSource + gas.rise * speed * age * (1.25 - 0.25 * age)};
    const double radius = gas.narrow + (gas.wide - gas.narrow) * age;
    const double thin = gas.narrow / radius;  // what spreads thins out, seen from the side
    const double there = std::min(1.0, age / kYoung) * (1 - age) * std::sqrt(1 - age);
    out.push_back({centre, radius, gas.density * strength * there * thin, light * colour_at(gas, age)});
  }
  return out;
}

/// Adds a puff to density and to density times colour.
void add(const Puff& puff, SynthVolume& volume) {
  Int3 lo{}, hi{};
  for (int a = 0; a < 3; ++a) {
    const double at = (puff.centre[a] - volume.origin[a]) / volume.spacing,
                 reach = puff.radius / volume.spacing;
    lo[a] = std::max(1, int(std::ceil(at - reach)));  // the border stays empty
    hi[a] = std::min(volume.size[a] - 2, int(std::floor(at + reach)));
  }
  for (int x = lo.x; x <= hi.x; ++x)
    for (int y = lo.y; y <= hi.y; ++y)
      for (int z = lo.z; z <= hi.z; ++z) {
        const Vec3d d = (1 / puff.radius) * (volume.position({x, y, z}) - puff.centre);
        const double left = 1 - dot(d, d);
        if (left <= 0) continue;
        const float density = float(puff.density * left * left * left);
        const std::size_t i = volume.index({x, y, z});
        volume.density[i] += density;
        volume.colour[i] += density * cast<float>(puff.colour);
      }
}

}  // namespace

const Gas kSmoke{.seed = 11,
                 .puffs = 180,
                 .from = -0.2,
                 .until = 0.75,
                 .life = 0.5,
                 .rise = 1.2,
                 .turn = 3.2,
                 .spread = 0.5,
                 .source = 0.2,
                 .narrow = 0.15,
                 .wide = 0.38,
                 .density = 1.5,
                 .detail = 0.75,
                 .colours = {{0.36, 0.34, 0.35}, {0.5, 0.5, 0.52}, {0.62, 0.63, 0.66}, {0.7, 0.72, 0.76}}};

const Gas kFire{.seed = 23,
                .puffs = 420,
                .from = -0.2,
                .until = 1.1,
                .life = 0.16,
                .rise = 1.15,
                .turn = 2.0,
                .spread = 0.42,
                .source = 0.14,
                .narrow = 0.24,
                .wide = 0.16,
                .density = 3,
                .detail = 0.85,
                .colours = {{1.0, 0.93, 0.66}, {1.0, 0.66, 0.2}, {0.9, 0.3, 0.06}, {0.3, 0.06, 0.04}}};

SynthVolume gas_lattice() {
  SynthVolume out;
  out.spacing = kVoxel;
  out.size = kVoxels;
  out.origin = -0.5 * kVoxel * cast<double>(kVoxels - Int3{1, 1, 1});
  return out;
}

SynthVolume gas_at(const Gas& gas, double time, double light) {
  SynthVolume out = gas_lattice();
  const std::size_t count = std::size_t(out.size.x) * out.size.y * out.size.z;
  out.density.assign(count, 0);
  out.colour.assign(count, {});
  for (const Puff& puff : puffs_at(gas, time, light)) add(puff, out);
  const double carried = 0.8 * gas.rise / gas.life * time;  // the detail goes with what rises
  for (int x = 0; x < out.size.x; ++x)
    for (int y = 0; y < out.size.y; ++y)
      for (int z = 0; z < out.size.z; ++z) {
        const std::size_t i = out.index({x, y, z});
        if (out.density[i] == 0) continue;
        out.colour[i] *= 1 / out.density[i];
        const double fine = cloud(kFeatures * (out.position({x, y, z}) - Vec3d{0, 0, carried}));
        out.density[i] *= float(1 + gas.detail * (2 * fine - 1));
      }
  return out;
}

Gathered gather_along(const SynthVolume& volume, const Ray& ray, double until) {
  Gathered out;
  double from = 0, to = until;  // between the first voxels and the last: beyond is nothing
  for (int a = 0; a < 3; ++a) {
    const double lo = volume.origin[a], hi = lo + volume.spacing * (volume.size[a] - 1);
    const double inverse = 1 / ray.direction[a];
    const double s = (lo - ray.origin[a]) * inverse, t = (hi - ray.origin[a]) * inverse;
    if (std::isnan(s) || std::isnan(t)) continue;  // along a side, in its plane
    from = std::max(from, std::min(s, t));
    to = std::min(to, std::max(s, t));
  }
  if (!(from < to)) return out;
  const int steps = std::max(1, int(std::ceil((to - from) * kStepsPerVoxel / volume.spacing)));
  const double dt = (to - from) / steps;
  for (int i = 0; i < steps && out.transmittance > kOpaque; ++i) {
    const SynthVolume::Sample here = volume.at(ray.origin + (from + (i + 0.5) * dt) * ray.direction);
    if (here.density <= 0) continue;
    const double hidden = -std::expm1(-here.density * dt);
    out.emission += out.transmittance * hidden * here.colour;
    out.transmittance *= 1 - hidden;
  }
  return out;
}

}  // namespace splinevox::data

namespace splinevox {

SynthVolume::Sample SynthVolume::at(const Vec3d& place) const {
  int base[3];
  Vec3d share;
  for (int a = 0; a < 3; ++a) {
    const double at = (place[a] - origin[a]) / spacing;
    if (!(at >= 0 && at <= size[a] - 1)) return {};
    base[a] = std::min(int(at), size[a] - 2);
    share[a] = at - base[a];
  }
  Sample out;
  double weights[kCorners];
  trilinear_weights(share, weights);
  for (int c = 0; c < kCorners; ++c) {
    const std::size_t i = index({base[0] + (c >> 2), base[1] + (c >> 1 & 1), base[2] + (c & 1)});
    if (density[i] == 0) continue;
    const double weight = weights[c] * double(density[i]);
    out.density += weight;
    out.colour += weight * cast<double>(colour[i]);
  }
  if (out.density > 0) out.colour *= 1 / out.density;
  return out;
}

}  // namespace splinevox
