// SPDX-License-Identifier: Apache-2.0
#include "data/synth/way.hpp"

#include <cmath>

#include "data/synth/geometry.hpp"

namespace splinevox::data {

double draw_unit(std::mt19937_64& rng) { return double(rng() >> 11) / double(1ull << 53); }

Wander::Wander(std::mt19937_64& rng) {
  for (int k = 0; k < kSines; ++k) {
    swings_[std::size_t(k)] = k + 0.5 + draw_unit(rng);
    phase_[std::size_t(k)] = 2 * M_PI * draw_unit(rng);
  }
}

double Wander::at(double time) const {
  double sum = 0, square = 0;
  for (int k = 0; k < kSines; ++k) {
    const double amplitude = 1.0 / (k + 1);
    sum += amplitude * std::sin(2 * M_PI * swings_[std::size_t(k)] * time + phase_[std::size_t(k)]);
    square += amplitude * amplitude / 2;
  }
  return sum / std::sqrt(square);
}

Hand::Hand(double shake, std::mt19937_64& rng)
    : shake_(shake),
      position_{Wander(rng), Wander(rng), Wander(rng)},
      turn_{Wander(rng), Wander(rng), Wander(rng)} {}

Camera Hand::hold(Camera camera, double distance, double time) const {
  for (int a = 0; a < 3; ++a) camera.position[a] += shake_ * distance * position_[std::size_t(a)].at(time);
  const Turn held{camera.axes[0], camera.axes[1], camera.axes[2]};
  const Turn turned = held * turn_x(shake_ * turn_[0].at(time)) * turn_y(shake_ * turn_[1].at(time)) *
                      turn_z(shake_ * turn_[2].at(time));
  camera.axes = {turned.x, turned.y, turned.z};
  return camera;
}

}  // namespace splinevox::data
