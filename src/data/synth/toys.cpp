// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "data/synth/paint.hpp"
#include "data/synth/scene.hpp"

namespace splinevox::data {
namespace {

/// A beach ball: wedges in turn, pale caps, a belt of dots.
Vec3d beach_ball(const Vec3d& m) {
  static const Vec3d wedge[] = {rgb(0xe0503c), rgb(0xf6ead2), rgb(0x2c7fb8),
                                rgb(0xf6ead2), rgb(0xf2b134), rgb(0xf6ead2)};
  const double r = length(m), turn = (std::atan2(m.y, m.x) / (2 * M_PI) + 0.5) * 6, height = m.z / r;
  const int i = int(std::floor(turn)) % 6;
  const double into = turn - std::floor(turn), soft = 0.03 / std::max(0.1, std::hypot(m.x, m.y) / r);
  Vec3d c = mix(wedge[(i + 5) % 6], wedge[i], edge(into, 2 * soft));
  if (into > 0.5) c = mix(wedge[i], wedge[(i + 1) % 6], edge(into - 1, 2 * soft));
  c = mix(c, rgb(0x35424a), edge(0.13 - std::abs(height), 0.01) * dots(2 * turn, height / 0.26 + 0.5, 0.22));
  return mix(c, rgb(0x3c4a52), edge(std::abs(height) - 0.9, 0.03));
}

/// The back is the +x side of the cross-section: the side a bend `up` turns to.
Vec3d snake_skin(const Vec3d& m) {
  const double around = std::atan2(m.y, m.x) / (2 * M_PI), s = m.z, r = std::hypot(m.x, m.y);
  const double back = r > 0 ? m.x / r : 0, upper = edge(back + 0.35, 0.2);
  Vec3d c = mix(mix(rgb(0xf0deb0), rgb(0xd9b36a), bands(s, 0.08, 0.4)), rgb(0x3f9a5f), upper);
  c = mix(c, rgb(0x1d5a41), upper * checks(around * 10, s / 0.07));
  const double diamond = std::abs(around) * 7 + std::abs(std::remainder(s, 0.2)) * 14;
  c = mix(mix(c, rgb(0xf2d06b), edge(1.15 - diamond, 0.1)), rgb(0xd9542b), edge(0.85 - diamond, 0.1));
  const double eye = std::hypot(s - 2.45, 0.12 * (std::abs(around) - 0.16) * 2 * M_PI);
  c = mix(mix(c, rgb(0xfbf4d8), edge(0.042 - eye)), rgb(0x1c1c22), edge(0.024 - eye));
  return mix(c, c * 0.78, cloud(14.0 * m));
}

/// A ball that lies on the plinth, lifted by a height above it that depends on time.
void add_lifted_ball(Bodies& bodies, double (*height)(double time)) {
  constexpr double r = 0.2;
  const auto pose = [height](double t) {
    return Pose{{turn_z(0.7) * turn_x(0.5), {0.58, -0.4, kFloor + r + height(t)}}, {1, 1, 1}, {}};
  };
  bodies.push_back({make_ball(r), pose, beach_ball});
}

/// Above the plinth: out of every picture at first, falling ever faster from time 0.3 to 0.6, then 0.
double falling(double time) {
  constexpr double from = 3.2, begins = 0.3, ends = 0.6;
  const double fallen = std::clamp((time - begins) / (ends - begins), 0.0, 1.0);
  return from * (1 - fallen * fallen);
}

}  // namespace

void add_entering_ball(Bodies& bodies) { add_lifted_ball(bodies, falling); }

void add_leaving_ball(Bodies& bodies) {
  add_lifted_ball(bodies, [](double time) { return falling(1 - time); });
}

void add_bouncing_ball(Bodies& bodies) {
  constexpr double r = 0.17, height = 0.55;
  const auto pose = [](double t) {
    const double up = 0.5 + 0.5 * std::cos(4 * M_PI * t);  // 1 at the top, 0 where the ball touches the floor
    const double tall = 1 - 0.3 * std::pow(1 - up, 4) + 0.08 * std::pow(std::sin(4 * M_PI * t), 2);
    const double wide = 1 / std::sqrt(tall);  // keeps the volume
    const Place place{turn_z(1.2 * t) * turn_x(0.5), {0.60, -0.42, kFloor + r * tall + height * up}};
    return Pose{place, {wide, wide, tall}, {}};
  };
  bodies.push_back({make_ball(r), pose, beach_ball});
}

void add_sliding_ball(Bodies& bodies) {
  const auto pose = [](double t) {
    return Pose{{turn_x(0.5), Vec3d{-0.4, -0.15, -0.2} + t * Vec3d{0.8, 0.3, 0.4}}, {1, 1, 1}, {}};
  };
  bodies.push_back({make_ball(0.4), pose, beach_ball});
}

void add_snake(Bodies& bodies) {
  constexpr int pieces = 14;
  constexpr double piece = 0.185, length = pieces * piece;
  const auto radius = [](double s) {
    const double tail = std::min(1.0, 0.25 + 0.75 * s / 1.2), head = (s - 2.41) / 0.13;
    return 0.09 * tail + 0.045 * std::exp(-0.5 * head * head);
  };
  const auto pose = [](double t) {
    std::vector<std::pair<double, double>> bends;
    for (int i = 0; i < pieces; ++i) {
      const double w = 2 * M_PI * t, phase = 0.55 * i;
      double up = 0, side = 2.0 + 0.25 * std::sin(w - phase);  // most of it lies in a ring
      if (i >= 7) side = 1.3 * std::sin(w - phase + 3.85);     // the front sways
      if (i == 7 || i == 8) up = 3.7;                          // where it rears up
      if (i > 8 && i < 12) up = -0.5 + 0.5 * std::sin(2 * w - phase);
      if (i >= 12) up = -3.4 + 0.5 * std::sin(w);  // where the head looks ahead
      bends.push_back({up, side});
    }
    const Place tail{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}, {0.87, -0.06, -0.5}};
    return Pose{{}, {1, 1, 1}, arcs_of(tail, piece, bends)};
  };
  bodies.push_back({make_tube(length, radius, 0.14, 0.3), pose, snake_skin});
}

}  // namespace splinevox::data
