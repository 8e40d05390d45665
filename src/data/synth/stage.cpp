// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "data/synth/paint.hpp"
#include "data/synth/scene.hpp"

namespace splinevox::data {
namespace {

constexpr double kRadius = 0.92, kHalf = 0.07;

/// The plinth: rings of stones around a star on top, two rows of bricks on the side.
Vec3d stones(const Vec3d& m) {
  const double r = std::hypot(m.x, m.y), turn = std::atan2(m.y, m.x) / (2 * M_PI) + 0.5;
  const double grain = cloud(9.0 * m);
  const auto wall = [&](double across, double along, double cells) {
    const double cell = std::floor(along * cells + 0.5);
    const double tone = noise({7.3 * cell, 3.1 * std::round(10 * across), 0.5});
    const Vec3d stone = mix(mix(rgb(0x8c7b6b), rgb(0xb89f82), tone), rgb(0x6e7c85), 0.5 * grain);
    return stone;
  };
  if (m.z < kHalf - 0.03) {  // the side
    const double row = std::floor((m.z + kHalf) / 0.06), shifted = turn + row / 48;
    const double gap = std::max(bands(shifted * 24 + 0.5, 1, 0.06), bands(m.z + kHalf - 0.06, 10, 0.0012));
    return mix(wall(row, shifted, 24), rgb(0x4a4642), gap);
  }
  if (r > 0.74)
    return mix(wall(9, turn, 24), rgb(0x4a4642), std::max(bands(turn * 24 + 0.5, 1, 0.05), edge(0.752 - r)));
  const double points = 0.34 + 0.16 * std::cos(2 * M_PI * turn * 8);
  Vec3d c = mix(rgb(0x2f5d62), rgb(0x5b8a72), grain);
  c = mix(c, rgb(0xe6dcc3), 0.85 * edge(points - r, 0.015));
  c = mix(c, rgb(0xb9502f), edge(points - 0.07 - r, 0.015));
  c = mix(c, rgb(0xe7c66b), edge(0.15 - r, 0.015));
  c = mix(c, rgb(0x2f5d62), edge(0.10 - r, 0.015) * checks(m.x / 0.05, m.y / 0.05));
  const double ring = bands(r - 0.63, 10, 0.006) * dots(turn * 36, 0.5 + (r - 0.63) / 0.12, 0.3);
  c = mix(c, rgb(0xe7c66b), ring);
  return mix(c, c * 0.82, cloud(25.0 * m));
}

Vec3d clay(const Vec3d& m) {
  const double turn = std::atan2(m.y, m.x) / (2 * M_PI);
  const Vec3d c = mix(rgb(0xb5613c), rgb(0xd07f52), cloud(16.0 * m));
  const double zigzag = std::abs(std::remainder(turn * 10, 1.0)) * 0.09 - 0.02;
  return mix(mix(c, rgb(0xf1e3c6), edge(0.012 - std::abs(m.z - zigzag))), rgb(0x3b2b20), edge(m.z - 0.108));
}

/// One stalk with a blossom at its end, bending in the wind.
void add_stalk(Bodies& bodies, const Place& root, double phase, double strength, std::uint32_t petal) {
  constexpr int pieces = 4;
  constexpr double piece = 0.155, total = pieces * piece;
  const auto arcs = [=](double t) {
    const double w = 2 * M_PI * t;
    std::vector<std::pair<double, double>> bends;
    for (int i = 0; i < pieces; ++i)
      bends.push_back(
          {strength * std::sin(w + phase - 0.5 * i), 0.5 * strength * std::sin(2 * w + 2 * phase) + 0.3});
    return arcs_of(root, piece, bends);
  };
  const auto width = [](double s) {
    return 0.034 - 0.012 * s / total + 0.016 * std::exp(-std::pow((s - 0.3) / 0.09, 2));
  };
  const auto green = [](const Vec3d& m) {
    return mix(rgb(0x2f6b34), rgb(0x9ccb5b), bands(m.z, 0.075, 0.45) * (0.5 + 0.5 * noise(20.0 * m)));
  };
  bodies.push_back({make_tube(total, width, 0.052, 0.2),
                    [arcs](double t) {
                      return Pose{{}, {1, 1, 1}, arcs(t)};
                    },
                    green});
  const auto blossom = [petal](const Vec3d& m) {
    const double turn = std::atan2(m.y, m.x) / (2 * M_PI), r = std::hypot(m.x, m.y);
    const Vec3d c = mix(rgb(petal), mix(rgb(petal), rgb(0xffffff), 0.65), bands(turn * 7, 1, 0.45));
    return m.z < 0 ? rgb(0x5c9440) : mix(c, rgb(0xf6c945), edge(0.04 - r));
  };
  Shape head = make_ball(0.1);
  head.flat = {1, 1, 0.55};
  bodies.push_back({head,
                    [arcs](double t) {
                      return Pose{arcs(t).back().end * shift(0, 0, 0.02), {1, 1, 1}, {}};
                    },
                    blossom});
}

}  // namespace

void add_stage(Bodies& bodies) {
  bodies.push_back({make_disc(kRadius, kHalf, 0.02), still(shift(0, 0, kFloor - kHalf)), stones});
}

void add_plant(Bodies& bodies) {
  const double x = -0.44, y = 0.42;
  bodies.push_back({make_disc(0.15, 0.11, 0.02), still(shift(x, y, kFloor + 0.11)), clay});
  add_stalk(bodies, shift(x + 0.03, y + 0.05, kFloor + 0.2) * rotate(turn_x(-0.12)), 0.0, 1.0, 0xd94f70);
  add_stalk(bodies, shift(x - 0.07, y, kFloor + 0.2) * rotate(turn_y(-0.34)), 1.3, 0.8, 0x7c5cc4);
}

}  // namespace splinevox::data
