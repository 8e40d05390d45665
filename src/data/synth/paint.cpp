// SPDX-License-Identifier: Apache-2.0
#include "data/synth/paint.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox::data {
namespace {

double corner(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = std::uint64_t(x) * 0x9e3779b97f4a7c15ull ^ std::uint64_t(y) * 0xc2b2ae3d27d4eb4full ^
                    std::uint64_t(z) * 0x165667b19e3779f9ull;
  h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 29)) * 0x94d049bb133111ebull;
  return double((h ^ (h >> 32)) >> 11) / double(1ull << 53);
}

double smooth(double t) { return t * t * (3 - 2 * t); }

}  // namespace

Vec3d rgb(std::uint32_t hex) {
  return {double(hex >> 16 & 255) / 255, double(hex >> 8 & 255) / 255, double(hex & 255) / 255};
}

Vec3d mix(const Vec3d& a, const Vec3d& b, double t) { return a + t * (b - a); }

double edge(double x, double width) { return smooth(std::clamp(x / width + 0.5, 0.0, 1.0)); }

double bands(double x, double period, double share) {
  const double from_middle = std::abs(std::remainder(x, period));
  return edge(0.5 * share * period - from_middle);
}

double noise(const Vec3d& p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const double tx = smooth(p.x - fx), ty = smooth(p.y - fy), tz = smooth(p.z - fz);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
    sum += (dx ? tx : 1 - tx) * (dy ? ty : 1 - ty) * (dz ? tz : 1 - tz) *
           corner(std::int64_t(fx) + dx, std::int64_t(fy) + dy, std::int64_t(fz) + dz);
  }
  return sum;
}

double cloud(const Vec3d& p) { return (4 * noise(p) + 2 * noise(2.03 * p) + noise(4.01 * p)) / 7; }

double checks(double u, double v) {
  const double a = std::sin(M_PI * u), b = std::sin(M_PI * v);
  return edge(a * b, 0.15);
}

double dots(double u, double v, double r) {
  const double row = std::floor(v), x = u - 0.5 * (std::int64_t(row) & 1);
  return edge(r - std::hypot(x - std::floor(x) - 0.5, v - row - 0.5), 0.1);
}

}  // namespace splinevox::data
